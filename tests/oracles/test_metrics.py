"""Metrics computed sample by sample are those of ``control.step_info`` and of sums over the response."""

from dataclasses import replace
from itertools import pairwise

import control
import numpy as np
import pytest

from design.controllers.pi import PI
from design.evaluation import metrics
from design.evaluation.steps import run
from plants import Wrist
from plants.rig import built_in_rig
from plants.simulation.reference_profile import Asked

SAMPLES = 8000
TIME = np.arange(SAMPLES) * 0.001
REST = Wrist.flexion().rest()


def judged(angle, command, start=0.0, reference=1.0, held=0.0, rig=None):
    """Metrics of signals by the running tally, in plain Python."""
    judge, asked = metrics.of_step(start, reference, rig), Asked(reference, start, 0.0)
    tally = judge.begin(held)
    for k, (y, u) in enumerate(zip(angle, command, strict=True)):
        joint = REST._replace(angle=y)
        tally = judge.update(tally, float(k), asked, joint, joint, u)
    return judge.finish(tally, len(angle))


def second_order(seed: int) -> tuple[np.ndarray, float]:
    """Step response of a random second-order system, damped little or much, and its reference.

    The reference is off the steady state by up to 1 %, as a response that is not yet there.
    """
    rng = np.random.default_rng(seed)
    damping, speed = rng.uniform(0.2, 1.5), rng.uniform(2.0, 12.0)
    gain = rng.uniform(0.5, 30.0)
    system = control.tf([gain * speed**2], [1.0, 2.0 * damping * speed, speed**2])
    return np.asarray(control.step_response(system, TIME).outputs), gain * rng.uniform(0.99, 1.01)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize(("start", "sign"), [(0.0, 1.0), (5.0, -1.0)])
def test_times_and_overshoot_are_those_of_python_control(seed, start, sign):
    response, reference = second_order(seed)
    theirs = control.step_info(response, TIME, final_output=reference)
    ours = judged(start + sign * response, np.zeros(SAMPLES), start, start + sign * reference)
    assert float(ours.rise_time_s) == pytest.approx(theirs["RiseTime"], abs=1e-9)
    assert float(ours.settling_time_s) == pytest.approx(theirs["SettlingTime"], abs=1e-9)
    assert float(ours.overshoot_percent) == pytest.approx(theirs["Overshoot"], abs=1e-9)


@pytest.mark.parametrize("band", [0.01, 0.05])
def test_the_band_and_the_sample_time_are_those_of_the_rig(band):
    own = built_in_rig()
    rig = replace(own, sample_time=0.004, task=replace(own.task, band=band))
    response, reference = second_order(3)
    response, time = response[::4], TIME[::4]
    theirs = control.step_info(response, time, SettlingTimeThreshold=band, final_output=reference)
    ours = judged(response, np.zeros(len(time)), 0.0, reference, rig=rig)
    assert float(ours.rise_time_s) == pytest.approx(theirs["RiseTime"], abs=1e-9)
    assert float(ours.settling_time_s) == pytest.approx(theirs["SettlingTime"], abs=1e-9)
    assert (
        float(judged(response, np.zeros(len(time)), 0.0, reference).settling_time_s) != ours.settling_time_s
    )


def test_the_random_responses_are_of_every_kind():
    overshoots = [control.step_info(second_order(s)[0], TIME)["Overshoot"] for s in range(12)]
    assert min(overshoots) < 0.1
    assert max(overshoots) > 20.0


@pytest.mark.parametrize("seed", range(4))
def test_integrals_are_sums_over_the_samples(seed):
    rng = np.random.default_rng(seed)
    angle, command = rng.normal(10.0, 4.0, 500), rng.uniform(0.0, 4.0, 500)
    ours = judged(angle, command, start=3.0, reference=12.0, held=2.0)
    error, time = 12.0 - angle, np.arange(500) * 0.001
    expected = {
        "iae_deg_s": np.sum(np.abs(error)) * 0.001,
        "ise_deg2_s": np.sum(error**2) * 0.001,
        "itae_deg_s2": np.sum(time * np.abs(error)) * 0.001,
        "total_variation_V": np.abs(np.diff(command, prepend=2.0)).sum(),
        "steady_state_error_deg": abs(error[-1]),
    }
    for name, value in expected.items():
        assert float(getattr(ours, name)) == pytest.approx(value, rel=1e-12), name


def test_what_does_not_get_there_takes_for_ever():
    angle = np.linspace(0.0, 0.5, 200)
    ours = judged(angle, np.zeros(200))
    assert np.isinf([float(ours.rise_time_s), float(ours.settling_time_s)]).all()
    assert float(ours.overshoot_percent) == 0.0


def test_what_leaves_the_band_in_the_last_sample_has_not_settled():
    angle = np.ones(200)
    assert float(judged(angle, angle).settling_time_s) == 0.0
    angle[-1] = 1.021
    assert float(judged(angle, angle).settling_time_s) == np.inf
    angle[-2:] = [1.021, 1.0]
    assert float(judged(angle, angle).settling_time_s) == pytest.approx(0.199)


@pytest.mark.parametrize("gains", [(1.2, 2.2), (9.0, 60.0)])
@pytest.mark.parametrize("reference", [15.0, -15.0])
def test_the_compiled_tally_is_the_plain_one(gains, reference):
    w = Wrist.deviation()
    compiled, _, t = run(w, PI(*gains), reference, duration=3.0, record=True)
    plain = judged(t.angle[:-1, 0], t.command[:-1, 0], 0.0, reference, 100.0 / 49.4)
    for name in metrics.UNITS:
        got, want = float(getattr(compiled, name)[0]), float(getattr(plain, name))
        assert got == pytest.approx(want, rel=1e-10, abs=1e-12), name


def test_every_metric_has_a_unit():
    assert set(metrics.UNITS) == set(vars(judged(np.ones(3), np.ones(3))))


def test_a_step_that_begins_at_its_reference_is_never_completed():
    still = judged(np.full(SAMPLES, 5.0), np.zeros(SAMPLES), start=5.0, reference=5.0)
    assert np.isinf(still.rise_time_s)
    assert np.isinf(still.settling_time_s)
    assert (still.overshoot_percent, still.iae_deg_s) == (0.0, 0.0)


def under_way(before, angle, held, reference, task=None):
    """Metrics of a step from a reference held until then, the joint having come to where it is as before."""
    judge = metrics.of_step_under_way(float(len(before)), float(len(angle)), task=task)
    tally, asked = judge.begin(0.0), Asked(reference, held, 0.0)
    for k, y in enumerate([*before, *angle, *before]):  # what comes after the window counts as little
        joint = REST._replace(angle=y)
        tally = judge.update(tally, float(k), asked, joint, joint, 0.0)
    return judge.finish(tally, len(angle))


@pytest.mark.parametrize("size", [0.5, 12.0, -0.5])
def test_a_step_that_begins_under_way_is_one_from_where_the_joint_then_is(size):
    response, reference = second_order(2)
    way, before = 3.0 + size / reference * response[:3000], np.linspace(-20.0, 20.0, 70)
    ours, alone = under_way(before, way, 3.0, 3.0 + size), judged(way, np.zeros(3000), 3.0, 3.0 + size)
    assert np.isfinite(float(ours.rise_time_s))
    for name in metrics.UNITS:
        assert float(getattr(ours, name)) == pytest.approx(float(getattr(alone, name)), rel=1e-9), name


@pytest.mark.parametrize("share", [0.05, 1.0])
def test_a_joint_on_its_way_to_where_it_is_sent_back_to_overshoots_nothing(share):
    """Sent to 10, at 2 sent back to 5: it goes on, passes by and comes back."""
    way = share * np.concatenate([np.linspace(2.0, 9.0, 100), np.linspace(9.0, 5.01, 100), np.full(50, 5.01)])
    ours = under_way(np.zeros(10), way, share * 10.0, share * 5.0, task=share * 15.0)
    assert float(ours.overshoot_percent) == 0.0
    assert np.isinf(float(ours.rise_time_s))
    assert 0.19 < float(ours.settling_time_s) <= 0.2


TREADS = [(0.0, 4.0), (4.0, 4.0), (4.0, 8.0), (8.0, 5.0), (5.0, 5.0)]
"""References before and after the change that each stair begins with [deg]."""


def of_stairs(ways, sign=1.0):
    """Metrics of stairs, relative to a step of 15 deg: the angles on each of `TREADS`, of as many samples."""
    held = len(ways[0])
    judge = metrics.of_stairs(15.0, 0.0, float(held * len(ways)))
    tally = judge.begin(0.0)
    for i, ((before, reference), way) in enumerate(zip(TREADS, ways, strict=True)):
        asked = Asked(sign * reference, sign * before, float(held * i))
        for k, angle in enumerate(sign * way):
            joint = REST._replace(angle=angle)
            tally = judge.update(tally, float(held * i + k), asked, joint, joint, 0.0)
    return judge.finish(tally, held * len(ways))


def test_the_travel_of_the_stairs_is_all_that_the_pressure_moves_by():
    judge = metrics.of_stairs(15.0, 0.0, 100.0)
    asked = [Asked(after, before, 20.0 * i) for i, (before, after) in enumerate(TREADS)]
    for path in (np.random.default_rng(4).uniform(80.0, 120.0, 101), np.full(101, 100.0)):
        tally = judge.begin(0.0)
        for k, (before, after) in enumerate(pairwise(path)):
            ends = (REST._replace(pressure=p) for p in (before, after))
            tally = judge.update(tally, float(k), asked[k // 20], *ends, 0.0)
        assert float(tally.stairs.travel) == pytest.approx(np.abs(np.diff(path)).sum(), rel=1e-12)


def approaches(times):
    """Angles on each tread that come near exponentially, with so many samples to 37 %."""
    shares = [np.exp(-np.arange(60) / time) for time in times]
    return [after + (before - after) * s for (before, after), s in zip(TREADS, shares, strict=True)]


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("excesses", [(0.5, 0.2, 0.3), (0.2, 0.3, 0.5), (0.0, 0.0, 0.0)])
def test_the_overshoot_of_stairs_is_the_largest_beyond_a_reference_in_the_direction_of_its_change(
    excesses, sign
):
    """The ways to the references, and a move on a stair that asks for none, are no overshoot."""
    up, again, down = excesses
    ways = approaches([3.0] * 5)
    for way, (_, reference), excess in zip(ways, TREADS, (up, 3.0, again, -down, -3.0), strict=True):
        way[20] = reference + excess
    found = of_stairs(ways, sign)
    assert float(found.overshoot_percent) == pytest.approx(100.0 * max(excesses) / 15.0, abs=1e-9)


@pytest.mark.parametrize(
    "times", [(5.0, 1.0, 3.0, 4.0, 1.0), (2.0, 1.0, 8.0, 4.0, 1.0), (2.0, 1.0, 3.0, 9.0, 1.0)]
)
def test_stairs_settle_when_the_slowest_of_them_does_and_not_where_one_has_not(times):
    """Within 2 % of 15 deg, each from its own beginning."""
    ways = approaches(times)
    outside = [
        np.flatnonzero(np.abs(way - after) >= 0.3) for way, (_, after) in zip(ways, TREADS, strict=True)
    ]
    slowest = max(rows[-1] + 1 for rows in outside if rows.size)
    assert float(of_stairs(ways).settling_time_s) == pytest.approx(0.001 * slowest)
    for way in ways:
        late = way.copy()
        late[-1] += 0.31
        assert float(of_stairs([late if w is way else w for w in ways]).settling_time_s) == np.inf
