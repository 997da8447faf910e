"""An MPC under the requirement of a PI: what is claimed of its cases is what each does alone."""

from dataclasses import replace

import numpy as np
import pytest

from design.evaluation.cases import stack
from design.evaluation.runner import play
from design.mpc.formulations.real_time import real_time_mpc
from design.mpc.margins_at_rest import margins_at_rest
from design.mpc.problem import robust
from design.robustness.tuning.case_pool import pool_of
from design.robustness.tuning.robust_mpc import MOVES, SWINGS, least_move, longest_delay, tune_mpc
from design.robustness.tuning.robust_tuning import GUARD, RoundEffort
from design.synthesis.requirements import Limits
from design.synthesis.structure import weighted_mpc, with_gains
from plants import Wrist
from tests.robustness.test_robust_tuning import small

WRIST = Wrist.flexion()
QUICK = RoundEffort(pool=24, search=0, fresh=6)


@pytest.fixture(scope="module")
def tuned():
    return tune_mpc(small(), effort=QUICK)


@pytest.mark.suite
def test_every_case_holds_alone_under_the_printed_weights(tuned):
    """Made of the printed numbers by the MPC's own constructor."""
    last = tuned.final
    setting = robust(WRIST)
    weights = replace(setting.weights, swing=last.gains["swing"], move=last.gains["move"])
    alone = real_time_mpc(replace(setting, weights=weights, delay=int(last.gains["delay"])))
    assert tuned.holds
    assert last.problem.adverse
    worst = dict.fromkeys(last.at.values, 0.0)
    for case in last.problem.adverse:
        values = play(stack([case]), alone).values
        worst = {n: max(v, float(values[n][0])) for n, v in worst.items()}
    held = {n: v * (1.0 - GUARD.get(n, 0.0)) for n, v in Limits().named.items()}
    for name, value in worst.items():
        assert value <= float(last.at.values[name][0]) + 1e-9
        assert value <= held[name] + 1e-9


@pytest.mark.suite
def test_the_next_milder_weight_breaks_a_limit_of_the_set(tuned):
    last = tuned.final
    milder = SWINGS[SWINGS.index(last.swing) - 1]
    again = with_gains(
        WRIST, {"swing": milder, "move": least_move(small(), milder, last.delay), "delay": last.delay}
    )
    values = play(stack(last.problem.adverse), again).values
    held = {n: v * (1.0 - GUARD.get(n, 0.0)) for n, v in Limits().named.items() if n in values}
    assert any(np.max(values[n]) > v for n, v in held.items())


@pytest.mark.suite
def test_the_cost_is_the_worst_of_the_tasks_steps(tuned):
    last = tuned.final
    of_task = [s for s in last.problem.adverse if s.of_task]
    found = [float(play(stack([s]), last.controller).metrics.iae_deg_s[0]) for s in of_task]
    assert max(found, default=0.0) <= last.at.cost[0] + 1e-9


@pytest.mark.slow
def test_a_move_costs_the_least_with_which_the_nominal_loop_keeps_its_limits():
    required, swing = small(), 100.0
    late = (0.0, required.space.dead_time)

    def held(value, delay):
        found = margins_at_rest(weighted_mpc(WRIST, swing, value, delay), [WRIST], late)
        return max(found.Ms, found.Mt) <= Limits().named["Ms"]

    bare, known = (least_move(required, swing, d) for d in (0, longest_delay(required)))
    assert held(bare, 0)
    assert held(known, longest_delay(required))
    assert not held(MOVES[MOVES.index(bare) - 2], 0)  # the reserve may take one step of the ladder
    assert known < bare  # a dead time that is known costs less margin


def test_the_pool_is_as_large_as_it_is_asked_to_be():
    assert 24 < pool_of(small(), 48).shape[1] <= 48
