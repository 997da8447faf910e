"""Limits that no gains hold are called so, with the limit that is broken most and where."""

from dataclasses import replace

import numpy as np
import pytest

from design.evaluation.cases import Case
from design.evaluation.tasks import Task
from design.synthesis.evaluate import evaluate, out_of_range
from design.synthesis.requirements import Limits, Problem
from plants import Wrist
from plants.linearisation import RATES, branch_slopes

BRANCHES = tuple(branch_slopes(Wrist.flexion()))

AXES = ["flexion", "deviation"]
ONLY_MS = replace(Limits.none(), Ms=1.0)


@pytest.mark.slow
@pytest.mark.parametrize("axis", AXES)
def test_no_loop_with_an_integrator_has_a_sensitivity_below_one(solve, axis):
    t = solve(axis, ONLY_MS)
    assert not t.feasible
    assert not t.map.feasible.any()
    assert t.active == "Ms"
    assert t.at.values["Ms"][0] > 1.0
    place = t.problem.place("Ms", int(t.at.values_at["Ms"][0]))
    assert place in {f"{b}, {r} regulator rate" for b in BRANCHES for r in RATES}


@pytest.mark.parametrize("axis", AXES)
def test_a_command_that_hardly_moves_cannot_get_there(solve, axis):
    # The pressure that holds 15 degrees is further from rest than the command may travel.
    t = solve(axis, Limits(total_variation_V=0.3, steady_error_percent=0.5))
    assert not t.feasible
    assert t.active in ("total_variation_V", "steady_error_percent")
    assert t.problem.place(t.active, int(t.at.values_at[t.active][0])) in {
        s.name for s in t.problem.scenarios
    }


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("limits", [ONLY_MS, Limits(total_variation_V=0.3, steady_error_percent=0.5)])
def test_the_limit_that_is_named_is_the_one_broken_most(solve, axis, limits):
    t = solve(axis, limits)
    excess = {n: float(e[0]) for n, e in t.at.excess.items()}
    assert excess[t.active] == max(excess.values()) > 0.0
    value, limit = float(t.at.values[t.active][0]), limits.named[t.active]
    assert excess[t.active] == pytest.approx(value / limit - 1.0, rel=1e-12)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_reference_beyond_the_command_range_is_named_with_what_it_lacks(sign):
    w = Wrist.flexion()
    near, far = (Case(Task("virgin", 0.0, (r,), (1.0,)), w) for r in (5.0, sign * 40.0))
    found = out_of_range(Problem.of(w, [near, far]))
    assert found is not None
    scenario, lack = found
    assert scenario is far
    # Held on the line that it arrives on: x = (h + w) / a, above or below 100 kPa.
    wanted = (100.0 + sign * (40.0 + 6.0) / 0.36) / 49.4
    assert lack == pytest.approx(max(wanted - 4.0, -wanted), rel=1e-12)


def test_references_within_the_range_are_not():
    w = Wrist.deviation()
    assert out_of_range(Problem.of(w, [Case(Task("virgin", 0.0, (r,)), w) for r in (15.0, -15.0)])) is None


def test_an_unknown_cost_is_refused():
    w = Wrist.flexion()
    with pytest.raises(ValueError, match="unknown cost 'speed'; one of iae, itae, settling_time"):
        Problem.of(w, [Case(Task("virgin", 0.0, (5.0,)), w)], cost="speed")


def test_a_limit_of_none_is_no_limit():
    assert set(Limits().named) - set(Limits(Ms=None).named) == {"Ms"}
    w = Wrist.flexion()
    at = evaluate(Problem.of(w, [Case(Task("virgin", 0.0, (15.0,)), w)], ONLY_MS, duration=1.0), [3.0], [8.0])
    assert list(at.excess) == ["Ms"]
    np.testing.assert_allclose(at.worst_excess, at.values["Ms"] / 1.0 - 1.0)
