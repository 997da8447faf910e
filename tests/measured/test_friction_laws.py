"""Laws from displacement to force: a sum of springs that slip is found by its own law, and by no other."""

import numpy as np
import pytest

from benchmarks.friction import DT, ForceRun, ForceTask, coulomb, linear, maxwell_slip, shares


def slipping(seed):
    """Force of springs that slip at a force each, step by step, under a wandering displacement."""
    rng = np.random.default_rng(seed)
    t = np.arange(3000) * DT
    x = 10.0 * np.sin(0.7 * t + seed) + 4.0 * np.sin(2.3 * t) + np.cumsum(rng.normal(0.0, 0.01, t.size))
    stiff, most = np.array([3.0, 2.0]), np.array([2.4, 6.0])
    springs, force = np.zeros(2), np.zeros(t.size)
    for i in range(1, t.size):
        springs = np.clip(springs + stiff * (x[i] - x[i - 1]), -most, most)
        force[i] = springs.sum() + 0.5 * x[i]
    return ForceRun(x, force)


@pytest.fixture(scope="module")
def task():
    return ForceTask("springs that slip", (slipping(1), slipping(2)), (slipping(3),))


def left(task, law):
    (made,) = law(task)
    return np.sqrt(np.mean((made - task.held_out[0].force) ** 2)) / task.span


def test_springs_that_slip_are_found(task):
    assert left(task, maxwell_slip) < 0.02
    assert left(task, maxwell_slip) < 0.4 * left(task, coulomb) < left(task, linear)


def test_a_law_that_is_not_installed_has_no_error(task, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pysindy", None)
    assert shares(task, ["PySINDy"]) == {"PySINDy": None}
