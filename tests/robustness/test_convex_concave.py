"""The convex-concave PI holds its limits between grid points and has the largest Ki that there is."""

from functools import cache

import numpy as np
import pytest

from design.alternatives.convex_concave import (
    NOISE_GAIN,
    POINTS,
    Rows,
    Shape,
    Shaped,
    convex_concave,
    excesses,
    largest_Ki,
)
from design.controllers.pi import PI
from design.evaluation.cases import Case
from design.evaluation.tasks import Task
from design.margins import BranchResponse, branch_responses, margins
from design.synthesis.evaluate import evaluate
from design.synthesis.requirements import Limits, Problem
from plants import Wrist

SHAPES = {
    "all": Shape(),
    "noise alone": Shape(None, None, 0.5, None),
    "Ms": Shape(Ms=1.4, Mt=None, noise_gain=None),
    "Mt": Shape(Ms=None, Mt=1.05, noise_gain=None, delay_margin_s=None),
    "delay": Shape(Ms=4.0, Mt=None, noise_gain=None, delay_margin_s=0.12),
}
CASES = [("flexion", "all"), ("flexion", "Ms"), ("flexion", "delay"),
         ("deviation", "all"), ("deviation", "Mt"), ("deviation", "noise alone")]  # fmt: skip


@cache
def shaped(axis: str, name: str) -> Shaped:
    wrist = getattr(Wrist, axis)()
    return largest_Ki(branch_responses(wrist, POINTS), wrist.regulator.gain, SHAPES[name])


def by_control(wrist: Wrist, pi: PI, omega: np.ndarray) -> dict[str, float]:
    """Peaks of S and T, noise gain [V/deg] and delay margin [s] by python-control alone, on every
    branch of a wrist at both rates."""
    import control

    dt = 0.001
    c = (pi.Kp + pi.Ki * control.tf([dt], [1.0, -1.0], dt)) / pi.gain
    found = {"Ms": 0.0, "Mt": 0.0, "noise_gain": 0.0, "delay_margin_s": np.inf}
    for branch in ("transit", "line1", "line2"):
        for rate in ("slow", "fast"):
            plant = wrist.linearised(branch, rate)
            loop = control.ss(c) * plant
            assert np.abs(control.feedback(loop, 1).poles()).max() < 1.0
            of = control.frequency_response(loop, omega).complex
            into = control.frequency_response(c, omega).complex
            found["Ms"] = max(found["Ms"], np.abs(1.0 / (1.0 + of)).max())
            found["Mt"] = max(found["Mt"], np.abs(of / (1.0 + of)).max())
            found["noise_gain"] = max(found["noise_gain"], np.abs(into / (1.0 + of)).max())
            data = control.frd(of, omega, smooth=True)
            _, pm, _, _, wc, _ = control.stability_margins(data, returnall=True)
            found["delay_margin_s"] = min(found["delay_margin_s"], *(np.radians(np.mod(pm, 360.0)) / wc))
    return found


@pytest.mark.slow
@pytest.mark.parametrize(("axis", "name"), CASES)
def test_the_limits_hold_between_the_frequencies_of_the_grid(axis, name):
    wrist, shape = getattr(Wrist, axis)(), SHAPES[name]
    found = shaped(axis, name)
    at = by_control(wrist, PI(found.Kp, found.Ki), np.geomspace(0.02, 3000.0, 1517))
    for limit in ("Ms", "Mt", "noise_gain"):
        if getattr(shape, limit) is not None:
            assert at[limit] <= getattr(shape, limit) * 1.001
    if shape.delay_margin_s is not None:
        assert at["delay_margin_s"] >= shape.delay_margin_s * 0.999
    assert found.active
    for limit in found.active:
        assert at[limit] == pytest.approx(getattr(shape, limit), rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize(("axis", "name"), CASES)
def test_no_gains_of_a_dense_map_hold_them_with_more_Ki(axis, name):
    """The brute-force map knows nothing of convexity: every pair of gains by its sensitivities, and the
    delay margin from `design.margins`, so that other parts of the plane are looked at too."""
    wrist, shape = getattr(Wrist, axis)(), SHAPES[name]
    branches = branch_responses(wrist, 400)
    found = shaped(axis, name)
    Kp, Ki = np.meshgrid(
        found.Kp * np.append(np.geomspace(0.02, 8.0, 60), np.linspace(0.9, 1.1, 41)),
        found.Ki * np.append(np.linspace(0.98, 1.05, 15), np.geomspace(1.1, 6.0, 12)),
        indexing="ij",
    )
    Kp, Ki = Kp.ravel(), Ki.ravel()
    worst = np.full(Kp.size, -np.inf)
    for b in branches:
        z = np.exp(1j * b.omega * 0.001)
        c = Kp[:, None] + Ki[:, None] * (0.001 / (z - 1.0))
        loop = c * b.response / wrist.regulator.gain
        S = 1.0 / np.abs(1.0 + loop)
        for limit, size in (
            (shape.Ms, S), (shape.Mt, np.abs(loop) * S),
            (shape.noise_gain, np.abs(c) * S / wrist.regulator.gain),
        ):  # fmt: skip
            if limit is not None:
                worst = np.maximum(worst, size.max(axis=1) / limit - 1.0)
    linear = margins(branches, PI(Kp, Ki))
    held = (worst <= 0.0) & np.isfinite(linear.Ms)
    if shape.delay_margin_s is not None:
        held &= linear.delay_margin_s >= shape.delay_margin_s
    assert held.any()
    best = float(Ki[held].max())
    assert found.Ki <= best * 1.02
    assert found.Ki >= best / 1.02


def test_a_first_order_lag_in_closed_form():
    """Against G = 1/(1 + s T) a bound of the noise gain alone lets Kp approach it, as |C S| tends to Kp at
    high frequency; that of the PI is never exceeded at low, where |C S| is 1/|G| = 1."""
    omega = np.geomspace(1e-2, 3000.0, 600)
    lag = BranchResponse("lag", "one", omega, 1.0 / (1.0 + 0.5j * omega), np.ones(omega.shape, complex))
    found = largest_Ki([lag], 1.0, Shape(None, None, 3.0, None))
    # C S = (Kp s + Ki) (1 + s T) / (s (1 + s T) + Kp s + Ki), whose peak lies where |.|^2 is stationary.
    s = 1j * np.geomspace(1e-3, 1e4, 200_001)
    for gain, holds in ((1.0, True), (1.02, False)):
        c = found.Kp * s + gain * found.Ki
        size = np.abs(c * (1.0 + 0.5 * s) / (s * (1.0 + 0.5 * s) + c))
        assert (size.max() <= 3.0 * 1.002) == holds


def problem(limits: Limits) -> Problem:
    wrist = Wrist.flexion()
    runs = [Case(Task(start, 0.0, (15.0,)), wrist) for start in ("virgin", "line2")]
    return Problem.of(wrist, runs, limits, duration=4.0)


def test_the_simulated_limits_hold_after_the_gains_are_scaled_down():
    found = convex_concave(problem(Limits()))
    assert found.breaks == ()
    assert found.share < 1.0
    assert found.controller.Kp == pytest.approx(found.share * found.shaped.Kp)
    assert found.controller.Ki == pytest.approx(found.share * found.shaped.Ki)
    more = evaluate(found.problem, 1.03 * found.controller.Kp, 1.03 * found.controller.Ki)
    assert not more.feasible[0]


def test_where_no_share_holds_the_limits_the_broken_one_is_named():
    found = convex_concave(problem(Limits(total_variation_V=0.1)))
    assert "total_variation_V" in found.breaks


def test_without_limits_of_the_problem_the_noise_gain_is_left():
    shape = Shape.of(Limits.none())
    assert shape == Shape(None, None, NOISE_GAIN, None)
    wrist = Wrist.flexion()
    branches = branch_responses(wrist, 300)
    found = largest_Ki(branches, wrist.regulator.gain, shape)
    assert found.active == ("noise_gain",)


@pytest.mark.parametrize("shape", [Shape(Ms=1.0), Shape(Mt=0.9)])
def test_a_peak_that_no_loop_can_hold_is_refused(shape):
    with pytest.raises(ValueError, match="limited to more than 1"):
        largest_Ki(branch_responses(Wrist.flexion(), 100), 49.4, shape)


def test_what_exceeds_a_limit_is_told_as_a_share_of_it():
    wrist = Wrist.flexion()
    branches = branch_responses(wrist)
    rows = Rows.of(branches, 49.4)
    at = by_control(wrist, PI(3.0, 10.0), branches[0].omega)
    told = excesses(rows, Shape(1.5, 1.2, 0.1, None), 49.4, 3.0, 10.0)
    assert float(told["Ms"]) == pytest.approx(at["Ms"] / 1.5 - 1.0, rel=1e-6)
    assert float(told["Mt"]) == pytest.approx(at["Mt"] / 1.2 - 1.0, rel=1e-6)
    assert float(told["noise_gain"]) == pytest.approx(at["noise_gain"] / 0.1 - 1.0, rel=1e-6)
