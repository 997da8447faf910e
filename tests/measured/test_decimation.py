"""Rows closer than a regulator needs are left out; the command acts by its mean in between, at its time."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.signal import lfilter

from plants.measured.campaigns.campaign import load_campaign, load_recording
from plants.measured.campaigns.decimation import decimated, for_sample_time, mean_held, rows_for
from plants.measured.campaigns.playback import Playback
from plants.measured.campaigns.recording import Recording
from plants.measured.trace.start import starting
from plants.wrist import Wrist
from tests.rig.soft.named import finger

MS = 0.001


def of_random_levels(seconds=20.0, seed=5):
    """A command that jumps at any ms, logged every ms."""
    rng = np.random.default_rng(seed)
    time = np.arange(round(seconds / MS)) * MS
    jumps = np.cumsum(rng.integers(200, 700, 60))
    return Recording(
        "fast.csv", time, rng.uniform(0.0, 4.0, 61)[np.searchsorted(jumps, np.arange(len(time)))]
    )


@pytest.mark.parametrize("rows", [5, 10])
def test_a_lag_answers_the_mean_as_it_answers_the_command(rows):
    tau, fast = 0.1, of_random_levels()

    def lag(command, dt):
        pole = np.exp(-dt / tau)
        return lfilter([0.0, 1.0 - pole], [1.0, -pole], command)

    exact, slow = lag(fast.command, MS)[::rows], decimated(fast, rows)
    error = np.abs(lag(slow.command, rows * MS) - exact)
    held_late = np.abs(lag(fast.command[::rows], rows * MS) - exact)
    assert error.max() < 0.15 * held_late.max()
    assert error.max() < np.ptp(fast.command) * (rows * MS / tau) ** 2 / 8.0 * 1.05


def test_what_is_measured_keeps_its_rows():
    fast = of_random_levels(2.0)
    logged = replace(fast, angle=np.sin(fast.time), extra={"T_C": fast.time})
    slow = decimated(logged, 8)
    np.testing.assert_array_equal(slow.angle, np.sin(slow.time))
    np.testing.assert_array_equal(slow.extra["T_C"], slow.time)
    assert np.diff(slow.time) == pytest.approx(8 * MS)


def test_a_mean_is_an_area_over_a_time():
    time, values = np.arange(100) * 0.01, np.random.default_rng(2).normal(size=100)
    edges = np.array([0.0, 0.013, 0.4, 0.77, 1.0])
    fine = np.repeat(values, 1000)  # held, every 10 us
    areas = [fine[round(a * 1e5) : round(b * 1e5)].mean() for a, b in pairwise(edges)]
    np.testing.assert_allclose(mean_held(time, values, edges), areas, rtol=0.0, atol=1e-12)


def test_rows_stay_where_a_channel_is_held_or_the_regulator_is_fast():
    fast = of_random_levels(2.0)
    held = replace(fast, angle=fast.time, renewed={"angle_deg": np.arange(len(fast.time)) % 33 == 0})
    assert rows_for([held], 0.2) == 1
    assert rows_for([fast], 0.005) == 1
    assert rows_for([fast], 0.05) == 5
    assert rows_for([fast], 2.0) == 10


def test_a_log_closer_than_the_samples_of_a_plant_is_played_at_these(tmp_path):
    wrist, fast = Wrist.flexion(), replace(of_random_levels(8.0), name="close.csv")
    time = np.arange(2 * len(fast.time)) * (MS / 2.0)
    rows = "".join(f"{t:.4f},{u},0.0\n" for t, u in zip(time, np.repeat(fast.command, 2), strict=True))
    (tmp_path / "close.csv").write_text("time_s,command_V,angle_deg\n" + rows)
    read = load_recording(tmp_path / "close.csv")
    assert np.diff(read.time) == pytest.approx(wrist.rig.sample_time)
    _, angle = Playback(read, wrist.rig.sample_time).play(wrist)
    _, exact = Playback(fast, wrist.rig.sample_time).play(wrist)
    np.testing.assert_array_equal(angle, exact)


@pytest.mark.parametrize(("sample_time", "step"), [(0.0025, 0.005), (0.01 / 3.0, 0.01), (0.002, 0.002)])
def test_rows_fall_on_samples(sample_time, step):
    assert np.diff(for_sample_time(of_random_levels(1.0), sample_time, 0.01).time) == pytest.approx(step)


@pytest.mark.slow
def test_a_guessed_rig_is_fitted_on_fewer_rows_and_says_so(tmp_path):
    rig = finger()
    rig = replace(rig, logger=replace(rig.logger, row=0.002))
    rig.write(tmp_path / "fast", ("stairs",), ("check",))
    begun = starting(load_campaign(tmp_path / "fast"))
    remark = next(r for r in begun.instrument if r.habit == "decimated")
    assert remark.value == 0.01
    assert "one every 0.01 s is used" in str(remark)
    assert np.diff(begun.campaign.fit[0].time) == pytest.approx(0.01)
    assert begun.parameters.rig.sample_time <= 0.01
