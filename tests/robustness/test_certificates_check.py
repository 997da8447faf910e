"""What the check outside the solver does not confirm is no certificate, whatever the solver says."""

from dataclasses import replace

import numpy as np
import pytest

from design.controllers.pi import PI
from design.robustness.certificates.continuous import check, lmi, popov, quadratic
from design.robustness.certificates.continuous.form import Form
from design.robustness.certificates.continuous.ladder import certifies, certify
from design.robustness.certificates.continuous.search import search
from design.robustness.certificates.reasons import NotConfirmed
from design.robustness.loop_model import LoopModel
from design.synthesis import convex
from plants import Wrist
from reports.robustness.reasons import no_certificate

LOOP = LoopModel.of(Wrist.flexion(), PI(1.2, 2.2))
TIMID = LoopModel.of(Wrist.flexion(), PI(0.5, 0.5))


@pytest.mark.parametrize("dead_time", [0.0, 0.05])
@pytest.mark.parametrize(("rung", "model"), [(quadratic.RUNG, TIMID), (popov.RUNG, LOOP)])
def test_a_form_that_was_tampered_with_is_refused(rung: str, model: LoopModel, dead_time: float) -> None:
    form = search(model, rung, dead_time=dead_time).form
    assert form is not None
    assert check.margin(form, model, dead_time) > 0.0
    flipped = form.P.copy()
    flipped[0, 2] = flipped[2, 0] = -flipped[0, 2]
    broken = [
        replace(form, P=flipped),
        replace(form, P=-form.P),
        replace(form, P=form.P * np.nan),
        replace(form, P=np.diag([1.0, 1.0, -1.0, *np.ones(form.order)])),
        replace(form, decay=10.0),
    ]
    if form.open_law:
        broken += [replace(form, popov=-form.popov), replace(form, popov=100.0 * form.popov)]
        broken += [replace(form, multipliers=(0.0, 0.0)), replace(form, slopes=(0.1, 0.2))]
    if form.order:
        broken += [replace(form, S=0.0), replace(form, R=-form.R), replace(form, R=0.0)]
    for other in broken:
        assert not check.margin(other, model, dead_time) > check.CONFIRMED
    assert check.margin(form, model, 0.05 - dead_time) < 0.0  # made for another number of moments


def test_moments_are_used_only_while_they_bound_what_is_under_way_from_the_right_side(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """By Bessel's inequality they are no more than all of it, which has to count against the function."""
    form = search(LOOP, popov.RUNG, 0.1, 0.05).form
    assert form is not None
    assert check.margin(form, LOOP, 0.05) > check.CONFIRMED
    monkeypatch.setattr(check, "positive", lambda matrix: 0.5)  # as if all else held
    fastest = form.R / 0.05 / (2.0 * (form.S + form.R))
    for share, told in ((0.999, 0.5), (1.001, -1.0)):
        assert check.margin(replace(form, decay=share * fastest), LOOP, 0.05) == told


def test_the_check_sees_a_loop_that_the_form_was_not_made_for() -> None:
    form = search(LOOP, popov.RUNG).form
    assert form is not None
    assert check.margin(form, replace(LOOP, Ki=50.0), 0.0) < 0.0
    assert check.margin(form, replace(LOOP, slopes={"transit": 0.0803, "line1": 2.0}), 0.0) < 0.0
    assert check.margin(form, replace(LOOP, k_fast=90.0), 0.0) < 0.0


def test_margins_are_shares_and_have_no_unit() -> None:
    matrix = np.array([[2.0, 1.0], [1.0, 2.0]])
    unit = np.diag([1.0, 1000.0])
    assert check.positive(matrix) == pytest.approx(1.0 / 3.0)
    assert check.positive(unit @ matrix @ unit) == pytest.approx(1.0 / 3.0)
    assert check.negative(matrix) == -1.0
    assert check.positive(np.array([[1.0, 2.0], [2.0, 1.0]])) < 0.0


def test_a_solver_that_fails_is_named_and_nothing_is_claimed(monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*_: object) -> str:
        raise convex.Unsolved("CLARABEL: ran out of numbers; SCS: so did it")

    monkeypatch.setattr(convex, "solve", fails)
    for c in certify(LOOP, Wrist.flexion(), PI(1.2, 2.2)):
        assert not c.holds
        assert c.decay is c.margin is c.shape is None
        assert "CLARABEL: ran out of numbers; SCS: so did it" in c.reason.said
    assert not certifies(LOOP, popov.RUNG)
    assert "ran out of numbers" in quadratic.common_quadratic([-np.eye(2)]).reason.said


def test_a_solver_that_lies_is_not_believed(monkeypatch: pytest.MonkeyPatch) -> None:
    def lies(*_: object) -> lmi.Solution:
        return lmi.Solution(np.eye(3), {"popov": 1.0}, (1.0, 1.0), 0.5, "LIAR")

    monkeypatch.setattr(lmi, "widest", lies)
    found = search(LOOP, popov.RUNG)
    assert found.form is None
    assert isinstance(found.reason, NotConfirmed)
    assert no_certificate(found.reason).startswith("not confirmed: LIAR reports one")


@pytest.mark.parametrize("k_slow", [0.55, 20.0])
@pytest.mark.parametrize("order", [0, 3])
def test_what_the_check_says_of_the_fall_is_the_derivative_written_out(order: int, k_slow: float) -> None:
    """For a straight law, and parabolas under way, of which three moments tell all (Bessel with equality)."""
    model, tau, slope = replace(LOOP, k_slow=k_slow), 0.05, 0.2
    random = np.random.default_rng(order)
    root = random.normal(size=(3 + order, 3 + order))
    S, R = (0.7, 0.4) if order else (0.0, 0.0)
    form = Form(root @ root.T, 0.9, True, 1.7, (0.1, 0.3), (2.0, 5.0), S, R)
    low, kappa = min(k_slow, model.k_fast), abs(model.k_fast - k_slow)
    fall = check._fall(form, model, tau, slope, low)
    at, weights = np.polynomial.legendre.leggauss(12)
    at, weights = 0.5 * (at + 1.0), 0.5 * weights  # on [0, 1]
    polynomials = [np.polynomial.legendre.Legendre.basis(k, domain=[0.0, 1.0]) for k in range(order)]
    for x0, x1, q, share, bend, turn in random.normal(size=(20, 6)) * [3.0, 3.0, 10.0, 1.0, 30.0, 30.0]:
        sent = model.Ki * x0 - model.Kp * x1 / model.Tw
        z = np.polynomial.Polynomial([sent, bend, turn])  # z(t - tau s), over s
        arriving = float(z(1.0)) if order else sent
        steep = kappa / (1.0 + np.exp(share))
        psi = steep * q
        phi, moments = low * q + psi, [float(weights @ (z(at) * p(at))) for p in polynomials]
        X = np.array([x0, x1, q, *moments])
        moved = [-float(weights @ (z.deriv()(at) * p(at))) / tau for p in polynomials]
        dX = np.array([-x1 / model.Tw, -x1 / model.Tw + slope * phi, arriving - phi, *moved])
        squares = float(weights @ z(at) ** 2)
        falls = 2.0 * X @ form.P @ dX + 2.0 * form.popov * psi * dX[2]
        integral = psi * q if k_slow < model.k_fast else 0.5 * kappa * q**2  # no less than that of psi
        grows = X @ form.P @ X + 2.0 * form.popov * integral
        if order:
            falls += ((S + R) * sent**2 - S * arriving**2 - R * squares) / tau
            grows += (S + R) * squares
        sector = 2.0 * 3.5 * psi * (kappa * q - psi)  # half-way between the two slopes
        told = fall(np.array([*X, *([arriving] if order else []), psi])[:, None])
        assert float(told[0]) == pytest.approx(falls + 2.0 * form.decay * grows + sector, rel=1e-9)
