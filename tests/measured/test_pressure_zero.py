"""The zero of a pressure sensor is found beside the regulator: a recording starts off rest by it.

The rigs are those of `tests.rig.soft.named`, which share no code with the library; their bias is the pressure
where the command is zero.
"""

from dataclasses import replace

import numpy as np
import pytest

from plants.measured.campaigns.campaign import load_campaign
from plants.measured.instrument.logger import corrected
from plants.measured.trace.counting.zero import counted
from tests.rig.soft.named import arm_a, bender


def zero(folder):
    """The zero [kPa] that a campaign shows, None where it shows none."""
    remarks = counted(corrected(load_campaign(folder))[0])[1]
    return next((r.value for r in remarks if r.habit == "counted from"), None)


def test_the_zero_is_the_rigs_within_a_noise(tmp_path):
    rig = bender()
    rig.write(tmp_path, ("stairs", "steps", "wave"), ("check",))
    assert zero(tmp_path) == pytest.approx(rig.bias, abs=rig.logger.pressure_noise)


@pytest.mark.parametrize("share", [0.006, -0.008])
def test_an_offset_of_less_than_a_hundredth_of_the_range_is_no_leak(tmp_path, share):
    """As the offset of *soft1300* of `tests.rig.soft.drawn`, for which a leak was named."""
    rig = bender()
    most = rig.gain * (rig.high - rig.low)
    replace(rig, bias=share * most).write(tmp_path, ("stairs", "steps", "wave"), ("check",))
    assert zero(tmp_path) == pytest.approx(share * most, abs=rig.logger.pressure_noise)


def test_no_offset_is_none(tmp_path):
    replace(bender(), bias=0.0).write(tmp_path, ("stairs", "steps", "wave"), ("check",))
    assert zero(tmp_path) is None


def test_so_is_that_of_a_rig_that_never_rests(tmp_path):
    rig = arm_a()
    rig.write(tmp_path, ("large", "medium"), ("check",))
    assert zero(tmp_path) == pytest.approx(rig.bias, abs=2.0 * rig.logger.pressure_noise)


def test_under_single_sines_the_remark_says_that_they_do_not_tell(tmp_path):
    said = {}
    for name, rig, fit in (("sines", arm_a(), ("large", "medium")), ("steps", bender(), ("stairs", "steps"))):
        rig.write(tmp_path / name, fit, ("check",))
        remarks = counted(corrected(load_campaign(tmp_path / name))[0])[1]
        said[name] = next(str(r) for r in remarks if r.habit == "counted from")
    assert "record steps to tell" in said["sines"]
    assert "record steps" not in said["steps"]


def test_one_step_from_the_first_row_on_tells_no_zero(tmp_path):
    """Gain and zero are the same there."""
    time = 0.02 * np.arange(250)
    for seed, name in enumerate(("one", "two")):
        noise = np.random.default_rng(seed).normal(0.0, 0.05, 250)
        table = np.column_stack([time, np.full(250, 0.7), 2.0 + 30.0 * -np.expm1(-time / 0.6) + noise])
        np.savetxt(
            tmp_path / f"{name}.csv", table, "%.5g", ",", header="time_s,command_V,pressure_kPa", comments=""
        )
    (tmp_path / "campaign.toml").write_text(
        'axis = "pump"\nstage = "regulator"\nstart = "unknown"\nsample_time_s = 0.02\n'
        'fit = ["one.csv"]\nvalidate = ["two.csv"]\n'
    )
    assert zero(tmp_path) is None
