"""From within the region of a certificate the command is never clipped."""

from dataclasses import replace

import numpy as np
import pytest

from design.controllers.pi import PI
from design.evaluation.steps import run
from design.robustness.certificates.continuous import popov, quadratic, region
from design.robustness.certificates.continuous.ladder import certify
from design.robustness.certificates.continuous.virgin import time_on_virgin_curve
from design.robustness.loop_model import LoopModel
from plants import Wrist
from plants.effects.regulator.dead_time import DeadTime


@pytest.mark.slow
@pytest.mark.parametrize("delay", [0.0, 0.05])
@pytest.mark.parametrize("gains", [(1.2, 2.2), (2.32, 6.38), (6.0, 10.0)])
@pytest.mark.parametrize("built_in", [Wrist.flexion, Wrist.deviation])
def test_steps_up_to_the_largest_are_simulated_without_clipping(
    built_in: object, gains: tuple[float, float], delay: float
) -> None:
    wrist = built_in() if delay == 0.0 else built_in() + DeadTime(delay)
    controller = PI(*gains)
    found = region.largest(LoopModel.of(wrist, controller), wrist, controller, popov.RUNG)
    assert found.largest_step > 1.0
    for sign in (1.0, -1.0):
        for share in (0.3, 1.0):
            for start in ("line1", "line2", "inside"):
                r = sign * share * found.largest_step
                _, _, went = run(wrist, controller, r, wrist.rest(start), duration=6.0, record=True)
                assert went is not None
                assert went.command.min() > 0.0
                assert went.command.max() < 4.0


def test_the_simulator_can_tell_clipping() -> None:
    """The test above could fail: a step well beyond the region's largest does clip."""
    wrist, controller = Wrist.flexion(), PI(6.0, 10.0)
    found = region.largest(LoopModel.of(wrist, controller), wrist, controller, popov.RUNG)
    reference = 5.0 * found.largest_step
    _, _, went = run(wrist, controller, reference, wrist.rest("line1"), duration=1.0, record=True)
    assert went is not None
    assert went.command.max() == 4.0


def test_the_ellipsoid_touches_a_plane_and_lies_between_both() -> None:
    wrist, controller = Wrist.flexion(), PI(1.2, 2.2)
    model = LoopModel.of(wrist, controller)
    found = region.largest(model, wrist, controller, popov.RUNG)
    assert found.form is not None
    g, b = region.planes(wrist, controller, found.largest_step, 0.0, 0)
    c = region.level(found.form, g, b)
    # Points of the ellipsoid's border, by a factor of P.
    sphere = np.random.default_rng(0).normal(size=(3, 200_000))
    border = np.sqrt(c) * np.linalg.solve(
        np.linalg.cholesky(found.form.P).T, sphere / np.linalg.norm(sphere, axis=0)
    )
    reach = (g @ border / b[:, None]).max(axis=1)
    assert reach.max() <= 1.0 + 1e-12
    assert reach.max() > 0.999


def test_planes_are_the_range_of_the_command_on_the_lines() -> None:
    """On line 1 the command is at the upper plane exactly where (P + q) / gain is 4 V."""
    wrist = Wrist.deviation()
    p, r, x0, x1 = wrist.hysteresis, 7.0, 2.0, -1.0
    g, b = region.planes(wrist, PI(1.0, 1.0), r, 0.0, 0)
    h = r - x0 + x1
    on_line1 = p.rest_pressure + (h + p.w1) / p.a1
    on_line2 = p.rest_pressure + (h - p.w2) / p.a2
    for row, limit, pressure in [(0, 4.0, on_line1), (1, 0.0, on_line2)]:
        q = wrist.regulator.gain * limit - pressure
        assert g[row] @ [x0, x1, q] == pytest.approx(b[row])


@pytest.mark.slow
def test_the_shape_of_a_certificate_is_where_its_function_is_at_most_the_level() -> None:
    wrist, controller = Wrist.flexion(), PI(0.5, 0.5)
    model = LoopModel.of(wrist, controller)
    ladder = certify(model, wrist, controller, dead_times=(0.0,))
    assert [c.rung for c in ladder] == [quadratic.RUNG, popov.RUNG]
    for c in ladder:
        assert c.holds
        step = c.evidence["region"]["largest_step_deg"]
        start = np.array([step, 0.0, 0.5 * step])
        assert start @ c.shape @ start <= c.level * (1.0 + 1e-9)
        assert np.linalg.eigvalsh(c.shape)[0] > 0.0
        g, b = region.planes(wrist, controller, step, 0.0, 0)
        assert (np.einsum("ij,ji->i", g, np.linalg.solve(c.shape, g.T)) * c.level <= b**2 * (1 + 1e-9)).all()
    assert {c.rung for c in certify(model, wrist, controller, dead_times=(0.0,))} == {
        quadratic.RUNG,
        popov.RUNG,
    }


def test_a_reference_beyond_the_range_leaves_no_region() -> None:
    wrist, controller = Wrist.flexion(), PI(1.2, 2.2)
    found = region.largest(LoopModel.of(wrist, controller), wrist, controller, popov.RUNG)
    assert found.form is not None
    assert region.level(found.form, *region.planes(wrist, controller, 40.0, 0.0, 0)) == 0.0


def test_a_step_off_the_virgin_curve_is_covered_where_the_function_is_below_the_level_at_both_ends() -> None:
    """It leaves with the errors (r, 0) and q of the step's sign; without dead time V is a form of these."""
    wrist, controller = Wrist.flexion(), PI(1.2, 2.2)
    model = LoopModel.of(wrist, controller)
    found = region.largest(model, wrist, controller, popov.RUNG)
    assert found.form is not None
    M, told = region.start_matrix(found.form, model), []
    virgin = time_on_virgin_curve(wrist, controller, 5.0)
    assert virgin.leaves
    for r in (-14.0, -11.0, -8.0, -3.0, 3.0, 8.0, 12.0, 14.0):
        c = region.level(found.form, *region.planes(wrist, controller, r, 0.0, 0))
        for least, most in ((0.0, 10.0), (5.0, 30.0), (20.0, 60.0), (60.0, 200.0), (100.0, 400.0)):
            starts = [np.array([r, 0.0, np.sign(r) * q]) for q in (least, most)]
            leaves = replace(virgin, q_least=least, q_most=most)
            told.append(region.covers(found, model, wrist, controller, r, leaves))
            assert told[-1] == all(x @ M @ x <= c for x in starts)
            clipped, never = replace(leaves, clipped=True), replace(leaves, latest=np.inf)
            assert not region.covers(found, model, wrist, controller, r, clipped)
            assert not region.covers(found, model, wrist, controller, r, never)
    assert 5 < sum(told) < len(told) - 5
