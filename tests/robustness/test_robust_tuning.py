"""Tuning against the worst case ends with gains for which none worse is found, or says that it did not."""

import json
from dataclasses import replace

import numpy as np
import pytest

from design.controllers.pi import PI
from design.evaluation.scenarios import Scenario
from design.evaluation.sequence import Sequence, play
from design.robustness.box import box_of
from design.robustness.robust_tuning import SLACK, WORSE, tune_robustly
from design.robustness.samples.adversary import worst_case
from design.synthesis.requirements import COSTS, Limits, Problem, controller, evaluate
from design.synthesis.tuning import Region
from plants import Wrist
from plants.files import json_text
from plants.parameters.quantities import built_in
from reports.robustness.tuning import lines, record
from reports.shared.tuning import refused

WRIST = Wrist.flexion()
SCENARIOS = (Scenario("virgin", 0.0, 15.0, WRIST), Scenario("line2", 0.0, 15.0, WRIST))
COARSE = Region(Kp=(0.5, 40.0), Ki=(1.0, 100.0), points=12)


def problem(limits: Limits | None = None, **changes: object) -> Problem:
    return replace(Problem.of(WRIST, SCENARIOS, limits, duration=5.0), **changes)


@pytest.fixture(scope="module")
def tuned():
    return tune_robustly(problem(), box_of(built_in("flexion")), COARSE, 1, budget=800, rounds=8)


def test_it_ends_with_gains_for_which_no_worse_case_is_found(tuned):
    assert tuned.ended == "no worse case found"
    assert tuned.holds
    assert len(tuned.rounds) > 1
    last = tuned.rounds[-1]
    for case in last.cases:
        assert case.excess <= SLACK
        assert case.values["iae_deg_s"] <= (1.0 + WORSE) * last.tuning.at.cost[0]


def test_each_round_adds_what_was_found(tuned):
    assert tuned.rounds[0].tuning.problem.adverse == ()
    for before, after in zip(tuned.rounds, tuned.rounds[1:], strict=False):
        assert before.worst.sequence in before.added
        assert after.tuning.problem.adverse == before.tuning.problem.adverse + before.added


def test_the_first_gains_break_a_limit_that_the_last_ones_hold(tuned):
    """Judged apart from the tuning: the sequences of the first round, played under both gains."""
    first, last = tuned.rounds[0], tuned.rounds[-1]
    worst = first.worst
    assert worst.violated == ("overshoot_percent",)
    gains = [controller(problem(), t.Kp, t.Ki) for t in (first.tuning, last.tuning)]
    before, after = (play([worst.sequence], g).values["overshoot_percent"][0] for g in gains)
    assert before > 5.0 * (1.0 + SLACK)
    assert after <= 5.0
    fresh = worst_case(
        box_of(built_in("flexion")), gains[1], limits=Limits(), seed=99, budget=800, duration=5.0
    )
    assert fresh.excess < 0.5 * worst.excess


def test_the_price_is_that_of_the_plain_set(tuned):
    for price, t in ((tuned.before, tuned.rounds[0].tuning), (tuned.after, tuned.final)):
        at = evaluate(problem(), t.Kp, t.Ki)
        assert price.worst_cost == at.cost[0]
        nominal = play(
            [Sequence("virgin", 0.0, (15.0,), (5.0,), WRIST)], controller(problem(), t.Kp, t.Ki)
        ).metrics
        assert price.nominal_cost == nominal.iae_deg_s[0]
        assert price.settling_time_s == nominal.settling_time_s[0]
    # What was tuned on the plain set alone is the best there, to the resolution of the search.
    assert tuned.after.worst_cost >= 0.98 * tuned.before.worst_cost


def test_words_and_record(tuned):
    said = "\n".join(lines(tuned))
    assert said.count("round ") == len(tuned.rounds)
    assert "no worse case found" in said
    told = json.loads(json_text(record(tuned)))
    assert told["holds"] is True
    assert len(told["rounds"]) == len(tuned.rounds)
    assert told["price"]["after"]["worst_cost"] == tuned.after.worst_cost


@pytest.mark.suite
def test_a_set_that_no_gains_hold_ends_with_the_nearest():
    hard = Limits(overshoot_percent=1.0, total_variation_V=3.0)
    found = tune_robustly(
        problem(hard), box_of(built_in("flexion")), COARSE, 1, dead_time=0.3, budget=300, rounds=4
    )
    assert found.ended == "no gains hold the grown set"
    assert not found.holds
    assert found.refusal is not None
    assert refused(found.refusal).startswith("no: no gains in Kp")
    assert refused(found.refusal) in lines(found)
    assert found.rounds[0].tuning.feasible


def test_rounds_that_are_used_up_are_told():
    found = tune_robustly(problem(), box_of(built_in("flexion")), COARSE, 1, budget=300, rounds=1)
    assert found.ended == "rounds used up"
    assert not found.holds
    assert "rounds used up" in lines(found)[1]


def test_adverse_sequences_join_the_evaluation():
    late = Sequence("line2", 0.0, (10.0, -4.0), (0.8, 5.0), WRIST.with_values(Tw=0.3), 0.1, 1.0, "late")
    plain = Sequence("line1", 0.0, (-15.0,), (5.0,), WRIST)
    both = problem(adverse=(late, plain))
    Kp, Ki = np.array([3.0, 1.5, 9.0]), np.array([9.0, 3.0, 9.0])
    at, without = evaluate(both, Kp, Ki), evaluate(problem(), Kp, Ki)
    for i in range(3):
        values = play([late, plain], PI(Kp[i], Ki[i])).values
        for name in ("overshoot_percent", "total_variation_V", "steady_error_percent"):
            assert at.values[name][i] == max(without.values[name][i], *values[name])
        assert at.cost[i] == max(without.cost[i], *values[COSTS["iae"]])
    assert (at.values["Ms"] == without.values["Ms"]).all()
    assert at.values["overshoot_percent"][0] > without.values["overshoot_percent"][0]
    index = int(at.values_at["overshoot_percent"][0])
    assert both.place("overshoot_percent", index) == late.name
    assert both.place("cost", 0) == SCENARIOS[0].name
