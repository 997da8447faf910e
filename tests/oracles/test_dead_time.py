"""A tube of 50 ms shakes a loop tuned without one, and not a loop that keeps 60 ms of delay margin."""

from functools import cache

import numpy as np
import pytest

from design.controllers.pi import PI
from design.evaluation.cases import Case
from design.evaluation.tasks import Task
from design.margins import branch_responses, margins
from design.synthesis.requirements import NOMINAL, Limits, Problem
from design.synthesis.tuning import Region, tune
from plants import Wrist
from tests.oracles.plain_loop import Plant, closed_loop

TUBE = 0.050
WRISTS = {axis: getattr(Wrist, axis)() for axis in ("flexion", "deviation")}
FAST = {"flexion": (20.0, 60.0), "deviation": (30.0, 100.0)}
CAREFUL = {"flexion": (9.0, 22.0), "deviation": (12.0, 28.0)}


def delay_margin(axis, gains) -> float:
    return float(margins(branch_responses(WRISTS[axis]), PI(*gains)).delay_margin_s)


def swings(axis, gains, delay, seconds=16.0, reference=15.0) -> list[float]:
    """Peak-to-peak angle [deg] in each of the last four seconds."""
    angles, _ = closed_loop(Plant(WRISTS[axis].values), *gains, reference, seconds, delay)
    return [float(np.ptp(angles[-k * 1000 - 1000 : len(angles) - k * 1000])) for k in (3, 2, 1, 0)]


@pytest.mark.parametrize(("axis", "reference"), [("flexion", 15.0), ("flexion", -15.0), ("deviation", 15.0)])
def test_fast_gains_oscillate_for_ever_behind_the_tube(axis, reference):
    assert delay_margin(axis, FAST[axis]) < TUBE
    found = swings(axis, FAST[axis], TUBE, reference=reference)
    assert min(found) > 1.0
    assert found[-1] > 0.95 * found[0]


@pytest.mark.parametrize("axis", WRISTS)
def test_the_same_gains_are_quiet_without_the_tube(axis):
    assert max(swings(axis, FAST[axis], 0.0)) < 0.05


@pytest.mark.parametrize("axis", WRISTS)
@pytest.mark.parametrize("reference", [15.0, -15.0])
def test_gains_with_60_ms_of_margin_settle_behind_the_tube(axis, reference):
    assert delay_margin(axis, CAREFUL[axis]) >= 0.060
    assert max(swings(axis, CAREFUL[axis], TUBE, reference=reference)) < 0.05
    angles, _ = closed_loop(Plant(WRISTS[axis].values), *CAREFUL[axis], reference, 10.0, TUBE)
    assert abs(angles[-1] - reference) < 0.02 * 15.0


@pytest.mark.parametrize("axis", WRISTS)
def test_the_careful_gains_use_their_margin_up(axis):
    # Gains so slow that no tube could ever matter would prove nothing.
    assert delay_margin(axis, CAREFUL[axis]) < 0.100
    assert min(swings(axis, CAREFUL[axis], 0.150)) > 1.0


@cache
def tuned(axis: str, limits: Limits) -> tuple[float, float]:
    """Gains of least IAE on the two steps of the nominal plant from rest."""
    steps = [Case(Task("virgin", 0.0, (r,)), WRISTS[axis]) for r in (15.0, -15.0)]
    found = tune(Problem.of(WRISTS[axis], steps, limits, duration=5.0), Region(points=12), starts=3)
    assert found.feasible
    return found.Kp, found.Ki


@pytest.mark.slow
def test_the_fastest_gains_for_a_deviation_without_tube_oscillate_behind_one():
    gains = tuned("deviation", NOMINAL)
    assert delay_margin("deviation", gains) < TUBE
    assert max(swings("deviation", gains, 0.0)) < 0.05
    assert min(swings("deviation", gains, TUBE)) > 1.0


@pytest.mark.slow
@pytest.mark.parametrize("axis", WRISTS)
@pytest.mark.parametrize("reference", [15.0, -15.0])
def test_the_fastest_gains_that_keep_60_ms_settle_behind_it(axis, reference):
    gains = tuned(axis, Limits())
    assert delay_margin(axis, gains) >= 0.060
    assert max(swings(axis, gains, TUBE, reference=reference)) < 0.05
