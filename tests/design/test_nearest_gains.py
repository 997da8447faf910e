"""Where no gains hold every limit, the nearest are those of which all that they break is known, and least."""

import numpy as np

from design.synthesis.evaluate import Evaluation, best_of


def judged(cost, **excess):
    n = len(cost)
    gains, nowhere = np.arange(1.0, n + 1.0), np.zeros(n, np.intp)
    beyond = {name: np.array(e) for name, e in excess.items()}
    return Evaluation(gains, gains, np.array(cost), nowhere, {}, {}, beyond)


def test_gains_that_were_not_simulated_come_after_those_of_which_a_run_never_settles():
    """They break a limit of the linear loop by 2 %, and nobody knows what else."""
    at = judged([np.inf, 5.0, 4.0], Ms=[0.02, -0.1, -0.1], settling_time_s=[-1.0, np.inf, np.inf])
    assert best_of(at).Kp[0] == 3.0


def test_of_gains_of_which_a_run_never_settles_the_other_limits_decide():
    at = judged([5.0, 4.0], overshoot_percent=[0.1, 0.9], settling_time_s=[np.inf, np.inf])
    assert best_of(at).Kp[0] == 1.0


def test_a_run_that_settles_late_comes_before_one_that_never_does():
    at = judged([5.0, 4.0], overshoot_percent=[0.9, 0.0], settling_time_s=[0.2, np.inf])
    assert best_of(at).Kp[0] == 1.0


def test_gains_that_hold_every_limit_come_first_and_of_these_the_cheapest():
    at = judged([3.0, 5.0, 4.0], overshoot_percent=[0.1, -0.1, 0.0], settling_time_s=[-0.5, -0.5, -0.5])
    assert best_of(at).Kp[0] == 3.0
