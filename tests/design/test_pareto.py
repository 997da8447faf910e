"""The Pareto front is what its definition says, by comparing every controller with every other."""

from math import inf, isfinite

import numpy as np
import pytest

from design.comparison.pareto import margin_s, pareto_front
from design.comparison.rows import Standing


def standing(name: str, settling: float, margin: float, breaks=(), tolerated=None) -> Standing:
    return Standing(
        "flexion", name, 1.0, 1.0, 1.5, margin, 0.0, settling, 1.0, breaks, tolerated_delay_s=tolerated
    )


def beaten(one: Standing, by: Standing) -> bool:
    no_worse = by.worst_settling_s <= one.worst_settling_s and margin_s(by) >= margin_s(one)
    better = by.worst_settling_s < one.worst_settling_s or margin_s(by) > margin_s(one)
    return no_worse and better


@pytest.mark.parametrize("seed", range(20))
def test_on_the_front_is_who_is_beaten_by_none(seed):
    rng = np.random.default_rng(seed)
    pool = []
    for i in range(30):
        tolerated = float(rng.choice([0.02, 0.05, 0.3])) if rng.random() < 0.2 else None
        margin = inf if rng.random() < 0.1 else float(rng.uniform(0.01, 1.0))
        settling = inf if rng.random() < 0.1 else float(rng.uniform(0.2, 8.0))
        pool.append(standing(str(i), settling, margin, ("Ms",) if rng.random() < 0.3 else (), tolerated))
    able = [s for s in pool if not s.breaks and isfinite(margin_s(s)) and isfinite(s.worst_settling_s)]
    expected = {s.controller for s in able if not any(beaten(s, o) for o in able)}
    front = pareto_front(pool)
    assert {s.controller for s in front} == expected
    assert [s.worst_settling_s for s in front] == sorted(s.worst_settling_s for s in front)


def test_what_is_tolerated_in_simulation_counts_where_there_is_no_linear_loop():
    assert margin_s(standing("MPC", 1.0, inf, tolerated=0.01)) == 0.01


def test_of_none_that_meets_the_limits_the_front_is_empty():
    assert pareto_front([standing("PI", 1.0, 0.1, ("Ms",))]) == []
