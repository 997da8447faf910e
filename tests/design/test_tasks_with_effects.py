"""Tasks of wrists with effects: what is out of reach is said, with its reason, and the rest goes on."""

import numpy as np
import pytest

from design.evaluation.cases import Case, hindrance, stack, unreachable
from design.evaluation.scenarios import tuning_scenarios, within_reach
from design.evaluation.tasks import Task
from design.synthesis.answer import OutOfReach, bends_to_one_side, out_of_reach, refusal
from design.synthesis.evaluate import out_of_range, rollouts
from design.synthesis.requirements import Limits, Problem, default_problem
from design.synthesis.tuning import Region, tune
from design.synthesis.tuning_rules import baselines, reaction_curve, simc
from plants.effects import (
    CappedPressure,
    CommandedOpenings,
    Creep,
    DeadTime,
    GivingStop,
    HardStop,
    Inertia,
    LaminarLeak,
    Polynomial,
    Saturation,
    TubeDeadTime,
)
from plants.kernel import pytrees as tree
from reports.shared.tuning import refused
from tests.design.effect_samples import WRIST

UP = Task("virgin", 0.0, (15.0,))


def needed(wrist, reference=15.0):
    """Command [V] that a long simulation needs to hold a reference, by bisection on line 1 or 2."""
    low, high = (1.0, 6.0) if reference > 0 else (-2.0, 2.0)
    for _ in range(30):
        middle = 0.5 * (low + high)
        start = wrist.rest()
        end = float(wrist.simulate(np.full(60_000, middle), start, every=60_000).state.angle)
        low, high = (middle, high) if end < reference else (low, middle)
    return 0.5 * (low + high)


@pytest.mark.parametrize(
    "effect",
    [
        Creep(0.1, 2.0), Polynomial(-0.1, 0.05), Saturation(150.0), LaminarLeak(0.2),
        CommandedOpenings(5.0, 3.0, 260.0, -10.0, 0.5, 0.8),
    ],
)  # fmt: skip
@pytest.mark.parametrize("reference", [15.0, -15.0])
def test_the_command_that_lacks_is_the_one_that_a_simulation_finds(effect, reference):
    w = (WRIST + effect).with_values(k_slow=5.0)
    volts = needed(w, reference)
    scenario = Case(Task("virgin", 0.0, (reference,)), w)
    lack = unreachable(scenario, volts + 0.1, volts - 0.1)  # an empty range: both ends lack 0.1 V
    assert lack == pytest.approx(0.1, abs=1e-3)
    assert unreachable(scenario, volts - 0.01, volts + 0.01) == 0.0


@pytest.mark.parametrize(("rest", "aside"), [(0.0, True), (100.0, False)])
def test_a_rig_that_bends_to_one_side_is_sent_to_where_its_angle_is_counted_from_the_middle(rest, aside):
    w = WRIST.with_values(rest_pressure=rest)
    assert bends_to_one_side(w) == aside
    said = out_of_reach(Problem.of(w, [Case(Task("virgin", 0.0, (-15.0,)), w)], duration=1.0))
    assert (said is not None) == aside
    if said is not None:
        assert said.one_sided
        assert "`wrist design` on its log" in refused(said)


@pytest.mark.parametrize(
    ("effect", "words"),
    [
        (HardStop(-90.0, 11.0), "the end stop at +11 deg"),
        (GivingStop(-90.0, 11.0, 0.0), "the end stop at +11 deg"),
        (CappedPressure(140.0), "a supply of 140 kPa, where 158.3 kPa are needed,"),
        (Saturation(40.0), "a branch that no pressure takes to +15 deg"),
    ],
    ids=lambda e: getattr(e, "FORM", None),
)
def test_what_keeps_the_wrist_from_the_task_is_told(effect, words):
    w = WRIST + effect
    scenario = Case(UP, w)
    assert hindrance(scenario) == words
    assert unreachable(scenario, 0.0, 4.0) == np.inf
    problem = Problem.of(w, [scenario, Case(Task("line1", 15.0, (0.0,)), w)], duration=1.0)
    found = tune(problem, Region(points=5), starts=1)
    said = refusal(found)
    assert said == OutOfReach("0 to +15 deg from virgin, nominal plant", words, np.inf)
    assert refused(said) == f"no: {words} keeps the wrist from holding {said.scenario}"
    assert np.isfinite(found.Kp)


def test_a_stop_that_is_out_of_the_way_hinders_nothing():
    w = WRIST + HardStop(-16.0, 16.0) + CappedPressure(180.0)
    assert out_of_range(Problem.of(w, [Case(UP, w)], duration=1.0)) is None


def test_corners_behind_a_stop_or_above_the_supply_are_set_aside():
    w = WRIST + CappedPressure(160.0)  # the nominal task needs 158.3 kPa
    kept, aside = within_reach(tuning_scenarios(w))
    assert {s.plant for s in kept if s.task.reference > 0.0} >= {"nominal", "narrow steep quick"}
    wide = {f"wide {a} {b}" for a in ("flat", "steep") for b in ("quick", "slow")}
    assert {s.plant for s in aside} <= wide | {"narrow flat quick", "narrow flat slow"}
    assert all(s.plant != "nominal" and 15.0 in (s.task.angle, s.task.reference) for s in aside)
    assert any(s.plant == "wide flat slow" for s in aside)


def test_stacked_scenarios_keep_their_effects():
    w = WRIST + DeadTime(0.1) + Creep(0.1, 2.0)
    found = tuning_scenarios(w)[5:60:9]
    lanes = stack(found)
    wrist, state = lanes.wrist, lanes.state
    assert wrist.forms == w.forms
    np.testing.assert_array_equal(wrist.values["creep.gain"], np.full(len(found), 0.1))
    for i, s in enumerate(found):
        assert [float(x[i]) for x in tree.leaves(state)] == pytest.approx(
            [float(x) for x in tree.leaves(s.wrist.rest(s.task.start, s.task.angle))], abs=1e-12
        )
    problem = Problem.of(w, found, Limits(), duration=1.0)
    table = rollouts(problem, np.array([1.0, 3.0]), np.array([2.0, 9.0]))
    alone = rollouts(Problem.of(w, found[2:3], duration=1.0), np.array([3.0]), np.array([9.0]))
    assert table.iae_deg_s[1, 2] == alone.iae_deg_s[0, 0]


def test_the_default_problem_of_a_revised_plant_is_of_that_plant():
    problem = default_problem(WRIST + DeadTime(0.1))
    assert len(problem.scenarios) == 90
    assert {s.wrist.forms for s in problem.scenarios} == {(DeadTime,)}
    assert problem.place("Ms", 0) == "transit, slow regulator rate"


def test_reaction_curves_show_the_dead_time():
    plain, late = reaction_curve(WRIST), reaction_curve(WRIST + DeadTime(0.1))
    assert late.dead_time - plain.dead_time == pytest.approx(0.1, abs=0.005)
    assert late.time_constant == pytest.approx(plain.time_constant, rel=0.05)
    crept = reaction_curve(WRIST + Creep(0.2, 1.0))
    assert crept.gain > 1.1 * plain.gain
    assert all(np.isfinite([pi.Kp, pi.Ki]).all() for pi in baselines(WRIST + Inertia(0.15)).values())


@pytest.mark.parametrize(
    ("effect", "lag", "dead"),
    [
        (DeadTime(0.1), 0.16 + 1 / 18, 1 / 18 + 0.1),
        (TubeDeadTime(0.1, 0.04), 0.16 + 1 / 18, 1 / 18 + 0.1 + 0.04),
        (Inertia(0.07), None, None),  # two poles apart
        (Inertia(0.2), 1 / 9 + 0.04, 0.04 + 0.08),  # ringing: two halves of Tw
    ],
)
def test_the_half_rule_counts_tube_and_joint(effect, lag, dead):
    if lag is None:
        root = (0.16**2 - 4 * 0.07**2) ** 0.5
        first, second, third = sorted([1 / 9, (0.16 + root) / 2, (0.16 - root) / 2], reverse=True)
        lag, dead = first + second / 2, second / 2 + third
    dead += 0.0005
    pi = simc(WRIST + effect)
    assert pi.Kp == pytest.approx(lag / (WRIST.hysteresis.a1 * 2 * dead), rel=1e-12)
    assert pi.Kp / pi.Ki == pytest.approx(min(lag, 8 * dead), rel=1e-12)
