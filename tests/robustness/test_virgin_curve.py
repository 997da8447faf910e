"""Every simulated step leaves the virgin curve between the bounds, or never where that is said."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from design.controllers.pi import PI
from design.evaluation.steps import run
from design.robustness.certificates.continuous.virgin import time_on_virgin_curve
from plants import Wrist
from plants import dynamics as plant
from plants.wrist import SAMPLE_TIME
from reports.robustness.reasons import virgin_words

GAINS = [(0.3, 0.5), (0.0, 2.0), (1.2, 2.2), (3.13, 10.4), (6.0, 10.0), (12.0, 3.0), (2.0, 40.0), (1.3, 0.02)]


@pytest.mark.parametrize("reference", [15.0, -15.0, 4.0, -25.0])
@pytest.mark.parametrize("built_in", [Wrist.flexion, Wrist.deviation])
def test_the_simulator_leaves_within_the_bounds(built_in: object, reference: float) -> None:
    wrist = built_in()
    Kp, Ki = np.array(GAINS).T
    _, _, went = run(wrist, PI(Kp, Ki), reference, wrist.rest(), duration=25.0, record=True)
    assert went is not None
    left = 0
    for lane, gains in enumerate(GAINS):
        bounds = time_on_virgin_curve(wrist, PI(*gains), reference)
        moved = np.nonzero(went.static_angle[:, lane] != 0.0)[0]  # h is 0 on the virgin curve alone
        if not bounds.leaves:
            assert moved.size == 0
            assert bounds.stuck is not None
            continue
        if bounds.earliest > 24.0:
            continue
        if moved.size == 0:
            assert bounds.latest > 24.0
            continue
        left += 1
        # The sampled loop is late by the sample in which it leaves and half of one of the integrator's.
        at = moved[0] * SAMPLE_TIME
        assert bounds.earliest - 1e-9 <= at <= bounds.latest + 3.0 * SAMPLE_TIME
        q = abs(wrist.regulator.gain * went.command[moved[0], lane] - went.pressure[moved[0], lane])
        slack = 3.0 * SAMPLE_TIME * (gains[1] + 9.0 * gains[0]) * abs(reference) + 1.5
        assert bounds.q_least - slack <= q <= bounds.q_most + slack
    assert left >= 4


def test_virgin_ends_with_the_first_angle() -> None:
    """What the test above takes for granted, sample by sample with the plant's own step."""
    wrist, controller = Wrist.flexion(), PI(1.2, 2.2)
    _, _, went = run(wrist, controller, 15.0, wrist.rest(), duration=2.0, record=True)
    assert went is not None
    state, c = wrist.rest(), wrist.sampled()
    for n, command in enumerate(went.command[:, 0]):
        assert (float(state.memory.virgin) == 1.0) == (went.static_angle[n, 0] == 0.0)
        state = plant.step(state, float(command), c)


@pytest.mark.parametrize("k", [0.55, 9.0])
@pytest.mark.parametrize("gains", [(1.2, 2.2), (6.0, 10.0), (0.0, 2.0)])
def test_with_one_rate_both_bounds_are_the_time_itself(k: float, gains: tuple[float, float]) -> None:
    flexion = Wrist.flexion()
    wrist = flexion.with_values(k_slow=k, k_fast=k)
    bounds = time_on_virgin_curve(wrist, PI(*gains), 15.0)
    assert bounds.earliest == bounds.latest

    def met(_t: float, p: np.ndarray) -> float:
        return float(p[0] - 6.0 / 0.36)

    met.terminal = True  # type: ignore[attr-defined]
    top = 49.4 * 4.0 - 100.0
    went = solve_ivp(
        lambda t, p: k * (min(15.0 * (gains[0] + gains[1] * t), top) - p),
        (0.0, 60.0), [0.0], events=met, rtol=1e-10, atol=1e-10, max_step=0.01,
    )  # fmt: skip
    assert bounds.earliest == pytest.approx(went.t_events[0][0], abs=1e-6)


def test_a_step_that_cannot_leave_says_why() -> None:
    wrist = Wrist.flexion()
    stuck = time_on_virgin_curve(wrist, PI(1.0, 0.0), 15.0)
    assert not stuck.leaves
    assert math.isinf(stuck.earliest)
    assert "at most 15 kPa above rest" in virgin_words(stuck)
    wide = time_on_virgin_curve(wrist.with_values(w2=40.0), PI(1.0, 5.0), -15.0)  # 111 kPa below rest
    assert not wide.leaves
    assert "below rest" in virgin_words(wide)
