"""An angle sensor that shows nothing below zero biases nothing, and hides no offset."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from plants.errors import InputError
from plants.measured.campaigns.campaign import load_campaign
from plants.measured.campaigns.playback import Playback
from plants.measured.campaigns.recording import Recording
from plants.measured.instrument.logger import corrected
from plants.measured.instrument.stated import StatedHabits
from plants.measured.trace.rig_fit import fit_rig
from plants.measured.trace.suspect import check
from plants.parameters.files import built_in
from plants.rig import Zero
from tests.rig.campaign import make_rig, record
from tests.rig.soft.drawn import recordings, soft_actuator


def saturating(time, angle, **more):
    return Recording("a", time, np.zeros(len(time)), angle=angle, ranges={"angle_deg": (0.0, np.inf)}, **more)


def test_a_simulation_is_compared_as_the_sensor_reads_it():
    log = saturating(np.arange(5) * 0.01, np.array([0.0, 0.0, 1.0, 2.0, 0.0]))
    seen = Playback(log, 0.01).as_logged(np.array([-3.0, 0.2, 1.5, 2.0, -0.1]), "angle_deg")
    assert seen.tolist() == [0.0, 0.2, 1.5, 2.0, 0.0]
    assert log.shown("angle_deg").tolist() == [False, False, True, True, False]


@pytest.mark.parametrize(("way", "range_"), [(False, (-2.0, np.inf)), (True, (-np.inf, 2.0))])
def test_the_range_is_counted_as_the_angle_is(way, range_):
    log = saturating(np.arange(3) * 0.01, np.array([0.0, 1.0, 2.0])).counted_from(Zero(0.0, 2.0, way))
    assert log.ranges["angle_deg"] == range_


def clip(folder, low, high):
    for path in folder.glob("*.csv"):
        log = pd.read_csv(path)
        clipped = log.assign(angle_deg=log["angle_deg"].clip(low, high))
        clipped.to_csv(path, index=False, lineterminator="\n")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("axis", "seed", "low", "high", "habits"),
    [
        ("flexion", 621, 0.0, None, ["saturated"]),
        ("deviation", 622, 0.0, None, ["saturated"]),
        ("flexion", 624, None, 6.0, ["clipped"]),
        ("deviation", 625, -4.0, 7.0, ["clipped", "clipped"]),
    ],
)
def test_parameters_are_those_of_the_rig(tmp_path, axis, seed, low, high, habits):
    rig = make_rig(axis, [], seed)
    record(rig, tmp_path, short=True)
    clip(tmp_path, low, high)
    campaign = load_campaign(tmp_path)
    assert [r.habit for r in corrected(campaign)[1]] == habits
    check(corrected(campaign)[0])
    fitted = fit_rig(campaign, built_in(axis), 1).fit.fitted.parameters
    truth = rig.declared._asdict()
    # Of noise about zero only the upper half is read, which moves them by more than their standard errors.
    for name in ("a1", "w1", "a2", "w2", "s", "Tw"):
        assert fitted[name].value == pytest.approx(truth[name], rel=0.03), name


def test_a_range_that_is_stated_is_not_looked_for(tmp_path):
    rig = make_rig("flexion", [], 624)
    record(rig, tmp_path, short=True)
    clip(tmp_path, None, 6.0)
    plain = load_campaign(tmp_path)
    stated = replace(plain, logger=StatedHabits(ranges={"angle_deg": (-np.inf, 6.0)}))
    (found, remarks), (as_found, _) = corrected(stated), corrected(plain)
    assert [(r.habit, r.value, r.stated) for r in remarks] == [("clipped", 6.0, True)]
    assert "reaches 6 deg" in str(remarks[0])
    assert found.fit[0].ranges == as_found.fit[0].ranges == {"angle_deg": (-np.inf, 6.0)}
    with pytest.raises(
        InputError, match=r"csv: column 'angle_deg': 6 lies beyond \[logger\] angle_range_deg, -inf"
    ):
        corrected(replace(plain, logger=StatedHabits(ranges={"angle_deg": (-np.inf, 5.0)})))


def test_a_sensor_that_rests_within_its_range_is_not_saturated(tmp_path):
    rig = make_rig("flexion", [], 623)
    record(rig, tmp_path, short=True)
    for path in tmp_path.glob("*.csv"):
        log = pd.read_csv(path)
        dead = log["angle_deg"].where(log["angle_deg"].abs() > 0.5, 0.0)
        log.assign(angle_deg=dead).to_csv(path, index=False, lineterminator="\n")
    found, remarks = corrected(load_campaign(tmp_path))
    assert [r.habit for r in remarks] == ["resting"]
    assert not any(r.ranges for r in found.fit)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [200, 221, 228, 234, 241, 302])
def test_offsets_of_recordings_that_begin_saturated_are_found(tmp_path, seed):
    """Their first rows tell nothing of them; a regression of what follows does, to 0.5 % of the range."""
    actuator, fit = soft_actuator(seed), recordings(seed)
    actuator.write(tmp_path, fit, ("check",))
    campaign = load_campaign(tmp_path)
    found, remarks = corrected(campaign)
    assert {"saturated", "offset"} <= {r.habit for r in remarks}
    logged, left = ((*c.fit, *c.validate) for c in (campaign, found))
    taken = [a.angle[-1] - b.angle[-1] for a, b in zip(logged, left, strict=True)]
    # The same logs, of a sensor that does not saturate, with offsets and without.
    free = replace(actuator.logger, rests=False)
    with_offsets, without = (
        replace(actuator, logger=kept) for kept in (free, replace(free, offset=0.0))
    )  # fmt: skip
    true = [
        np.median(
            np.subtract(*(a.log(a.commands[n](), 100 + i)["angle_deg"] for a in (with_offsets, without)))
        )
        for i, n in enumerate((*fit, "check"))
    ]
    about = np.median(true[: len(fit)])
    assert taken == pytest.approx(np.array(true) - about, abs=0.005 * np.ptp(logged[0].angle))


@pytest.mark.parametrize("names", [("check.csv",), ("stairs.csv",), ("wave.csv", "check.csv")])
def test_recordings_of_small_strokes_tell_no_offset(tmp_path, names):
    """Nothing follows a first stroke that is never made, so there is nothing to regress."""
    actuator = soft_actuator(200)
    actuator.write(tmp_path, recordings(200), ("check",))
    for name in names:
        log = pd.read_csv(tmp_path / name)
        pressure = log["pressure_kPa"].iloc[0] + 0.02 * log["pressure_kPa"]
        still = log.assign(
            pressure_kPa=pressure, angle_deg=0.02 * log["angle_deg"].where(log.index > 60, 0.0)
        )
        still.to_csv(tmp_path / name, index=False, lineterminator="\n")
    _, remarks = corrected(load_campaign(tmp_path))
    assert "saturated" in {r.habit for r in remarks}
