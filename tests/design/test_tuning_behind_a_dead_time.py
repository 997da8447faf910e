"""Gains tuned on the plant with its dead time hold the limits on it; those of the declared plant do not."""

from functools import cache

import numpy as np
import pytest

from design.controllers.pi import PI
from design.evaluation.cases import Case
from design.evaluation.steps import run
from design.evaluation.tasks import Task
from design.synthesis.answer import refusal
from design.synthesis.evaluate import evaluate
from design.synthesis.requirements import Problem
from design.synthesis.tuning import Region, Tuning, tune
from plants.effects import DeadTime
from tests.design.effect_samples import WRIST

DECLARED = (3.13, 10.4)
"""What ``wrist tune`` says of the declared flexion."""

TUBE = WRIST + DeadTime(0.1)


@cache
def tuned() -> Tuning:
    scenarios = [
        Case(Task("virgin", 0.0, (15.0,)), TUBE), Case(Task("line2", 0.0, (15.0,)), TUBE),
        Case(Task("inside", 0.0, (-15.0,)), TUBE), Case(Task("line1", 15.0, (0.0,)), TUBE),
    ]  # fmt: skip
    region = Region(Kp=(0.5, 20.0), Ki=(1.0, 60.0), points=12)
    return tune(Problem.of(TUBE, scenarios, duration=8.0), region, starts=2)


def test_the_tuned_gains_hold_every_limit():
    found = tuned()
    assert found.feasible
    assert refusal(found) is None
    assert found.at.values["Ms"][0] <= 2.0
    assert found.at.values["delay_margin_s"][0] >= 0.060
    assert found.at.values["overshoot_percent"][0] <= 5.0


def test_the_declared_gains_break_limits_behind_the_tube():
    declared = evaluate(tuned().problem, *DECLARED)
    assert not declared.feasible[0]
    broken = {n for n, e in declared.excess.items() if e[0] > 0.0}
    assert {"Ms", "overshoot_percent"} <= broken
    assert declared.values["overshoot_percent"][0] > 10.0


def test_the_declared_gains_hold_them_without_it():
    scenario = Case(Task("virgin", 0.0, (15.0,)), WRIST)
    at = evaluate(Problem.of(WRIST, [scenario], duration=8.0), *DECLARED)
    assert bool(at.feasible[0])


@pytest.mark.parametrize("reference", [15.0, -15.0])
def test_the_tuned_step_settles_and_the_declared_one_swings_over(reference):
    found = tuned()
    judged, _, t = run(TUBE, PI(found.Kp, found.Ki), reference, record=True)
    other, _, _ = run(TUBE, PI(*DECLARED), reference)
    assert judged.overshoot_percent[0] < 5.0 < 10.0 < other.overshoot_percent[0]
    assert np.abs(t.angle[-2000:, 0] - reference).max() < 0.02 * 15.0
