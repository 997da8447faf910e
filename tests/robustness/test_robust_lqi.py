"""An LQI under the requirement of a PI: its claims are confirmed by python-control and by replay."""

from dataclasses import replace

import control
import numpy as np
import pytest

from design.controllers.lqi import LQI
from design.evaluation.cases import stack
from design.evaluation.runner import play
from design.robustness.checks import check
from design.robustness.tuning.robust_lqi import tune_lqi
from design.robustness.tuning.robust_tuning import GUARD
from design.synthesis.requirements import Limits
from plants import Wrist
from tests.robustness.test_lqi import continuous
from tests.robustness.test_robust_tuning import plain, small

pytestmark = pytest.mark.slow

WRIST = Wrist.flexion()


@pytest.fixture(scope="module")
def base():
    return plain().final


@pytest.fixture(scope="module")
def tuned(base):
    return tune_lqi(small(), base, rounds=6)


def test_it_begins_with_the_cases_of_the_pi_and_adds_those_that_break_a_limit(tuned, base):
    cases = [s.name for s in tuned.final.problem.adverse]
    assert cases[: len(base.problem.adverse)] == [s.name for s in base.problem.adverse]
    assert all(r.added for r in tuned.rounds[:-1])


def test_what_is_claimed_of_every_case_is_what_the_printed_gains_do(tuned):
    """Each case alone, under a controller that is made of the printed numbers."""
    last = tuned.final
    copied = LQI.of(WRIST, **{n: float(f"{v:.4g}") for n, v in last.gains.items()})
    worst = {"overshoot_percent": 0.0, "total_variation_V": 0.0}
    for case in last.problem.adverse:
        values = play(stack([case]), copied).values
        worst = {n: max(v, float(values[n][0])) for n, v in worst.items()}
    held = {n: v * (1.0 - GUARD.get(n, 0.0)) for n, v in Limits().named.items()}
    for name, value in worst.items():
        assert value <= float(last.at.values[name][0]) * (1.0 + 1e-9)
        assert value <= held[name] + 1e-9


def test_margins_are_those_of_python_control_on_every_corner_behind_the_dead_time(tuned):
    asked, c = small(), tuned.final.controller
    omega = np.geomspace(0.05, 150.0, 6000)
    peaks = []
    for Tw in asked.box.bounds("Tw"):
        for k_slow in asked.box.bounds("k_slow"):
            for slope in (0.0803, 0.36):
                for rate in (k_slow, WRIST.regulator.k_fast):
                    law, plant = continuous(c, slope, rate, Tw)
                    loop = -np.ravel(control.frequency_response(law * plant, omega).complex)
                    peaks += [1 / np.abs(1 + loop * np.exp(-1j * omega * t)).min() for t in (0.0, 0.05)]
    Ms = max(peaks)
    assert float(tuned.final.at.values["Ms"][0]) == pytest.approx(Ms, rel=0.03)  # hold and sampling apart
    assert Ms <= 2.0


def test_gains_that_hold_are_broken_by_no_fresh_sample(tuned):
    assert tuned.holds
    assert tuned.final.breaks == ()
    assert check(small(), tuned.final.controller, 1000, 77).broken == 0


def test_where_none_hold_the_limit_that_the_nearest_break_is_named(base):
    asked = small()
    strict = replace(asked, limits=replace(asked.limits, total_variation_V=0.3))
    found = tune_lqi(strict, base, rounds=2, generations=3)
    assert found.ended == "no gains hold the grown set"
    assert not found.holds
    assert found.final.breaks
