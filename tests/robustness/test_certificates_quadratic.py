"""A common quadratic form is found where theory says that there is one, and only there."""

import numpy as np
import pytest

from design.robustness.certificates.continuous import quadratic
from design.robustness.certificates.continuous.quadratic import common_quadratic
from design.robustness.certificates.continuous.search import fastest, search
from design.robustness.loop_model import LoopModel
from design.synthesis.convex import Unsolved


def pair(a: float) -> list[np.ndarray]:
    """Dayawansa and Martin (IEEE TAC 44 (1999) 751): a common quadratic form exists for
    a < 3 + sqrt(8) = 5.828 alone, though the switched system is stable a little beyond."""
    return [np.array([[-1.0, -1.0], [1.0, -1.0]]), np.array([[-1.0, -a], [1.0 / a, -1.0]])]


@pytest.mark.parametrize(("a", "exists"), [(2.0, True), (5.8, True), (5.86, False), (8.0, False)])
def test_the_published_border_is_met(a: float, exists: bool) -> None:
    found = common_quadratic(pair(a))
    assert found.holds is exists
    assert (found.shape is not None) is exists
    assert found.reason is not None if not exists else found.margin > 0.0


def test_the_form_falls_along_every_matrix_and_mixture() -> None:
    matrices = pair(4.0)
    P = common_quadratic(matrices, decay=0.2).shape
    assert np.linalg.eigvalsh(P)[0] > 0.0
    for share in np.linspace(0.0, 1.0, 11):
        A = share * matrices[0] + (1.0 - share) * matrices[1]
        assert np.linalg.eigvalsh(A.T @ P + P @ A + 0.4 * P)[-1] < 0.0


def test_matrices_that_commute_have_one_as_fast_as_their_slowest_pole() -> None:
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    matrices = [turn @ np.diag(p) @ turn.T for p in ([-1.0, -2.0, -5.0], [-4.0, -1.5, -0.7])]
    assert common_quadratic(matrices, decay=0.69).holds
    assert not common_quadratic(matrices, decay=0.71).holds


@pytest.mark.parametrize(("Kp", "Ki", "slope", "rate"), [(1.2, 2.2, 0.36, 9.0), (2.0, 1.0, 0.08, 2.0)])
def test_of_one_linear_loop_the_best_decay_is_its_slowest_pole(
    Kp: float, Ki: float, slope: float, rate: float
) -> None:
    import control

    p = control.tf("s")
    loop = (Kp + Ki / p) * rate / (p + rate) * slope / (0.16 * p + 1.0)
    slowest = -control.feedback(control.ss(loop), 1).poles().real.max()
    found = fastest(LoopModel(Kp, Ki, {"only": slope}, rate, rate, 0.16), quadratic.RUNG)
    assert found.form is not None
    assert 0.99 * slowest < found.form.decay < slowest


def test_a_switched_loop_with_an_unstable_corner_has_none() -> None:
    model = LoopModel(20.0, 200.0, {"transit": 0.08, "line": 0.36}, 0.55, 9.0, 0.16)
    assert search(model, quadratic.RUNG).form is None


def test_where_the_solver_finds_nothing_nothing_is_claimed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without a function there is no rate, no margin, and plain matrices have no dead time."""

    def unsolved(*_: object) -> None:
        raise Unsolved("CLARABEL: infeasible")

    monkeypatch.setattr(quadratic, "widest", unsolved)
    found = common_quadratic(pair(1.0), decay=0.5)
    assert (found.holds, found.decay, found.margin, found.dead_time) == (False, None, None, 0.0)
    assert found.about is None
    assert "infeasible" in str(found.reason)
