"""The check of functions with memory decides in fractions, and refuses what was tampered with."""

from dataclasses import replace
from decimal import Context, Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

from design.controllers.pi import PI
from design.robustness.certificates.memory import programme
from design.robustness.certificates.memory.check import _fall, below, confirm_common, confirm_line
from design.robustness.certificates.memory.loop import FixedLawLoop, growth_of
from design.robustness.certificates.reasons import NoneOfThisKind, NotConfirmed
from design.robustness.loop_model import LoopModel
from plants import Wrist
from plants.actuator import regulator

LOOP = LoopModel.of(Wrist.flexion(), PI(2.0, 4.0))
SLOPE = (0.36,)


def flipped(matrix: Any) -> Any:
    found = matrix.copy()
    found[0, 2] = found[2, 0] = -found[0, 2]
    return found


@pytest.mark.parametrize("samples", [0, 50])
def test_a_function_with_memory_that_was_tampered_with_is_refused(samples: int) -> None:
    loop = FixedLawLoop.of(LOOP, samples)
    form = programme.line(loop, SLOPE, 0.15).form
    assert form is not None
    assert confirm_line(form, loop).holds
    line, transit = form.line, form.transit
    broken = [
        replace(form, line=replace(line, P=flipped(line.P))),
        replace(form, line=replace(line, P=line.P * np.nan)),
        replace(form, line=replace(line, popov=-line.popov)),
        replace(form, line=replace(line, popov=100.0 * line.popov)),
        replace(form, transit=replace(transit, P=-transit.P)),
        replace(form, transit=replace(transit, P=2.0 * line.P)),  # not below the other
        replace(form, transit=replace(transit, popov=2.0 * line.popov + 1.0)),
        replace(form, cross=-form.cross),
        replace(form, cross=form.cross[:-1]),
        replace(form, cross=form.cross * np.nan),
        replace(form, gap=-form.gap),
        replace(form, multipliers=(0.0, 0.0, 0.0)),
        replace(form, multipliers=(-1.0, *form.multipliers[1:])),
        replace(form, decay=0.5),
        replace(form, decay=float("nan")),
        replace(form, inner=(0.2,)),
        replace(form, outer=(0.5,)),
    ]
    if samples:
        broken += [
            replace(form, line=replace(line, S=0.0)),
            replace(form, line=replace(line, R=-line.R)),
            replace(form, transit=replace(transit, S=2.0 * line.S + 1.0)),
        ]
    for other in broken:
        assert not confirm_line(other, loop).holds
    assert not confirm_line(form, FixedLawLoop.of(LOOP, 50 - samples)).holds  # another number of moments


@pytest.mark.parametrize("samples", [0, 50])
def test_a_common_function_that_was_tampered_with_is_refused(samples: int) -> None:
    loop = FixedLawLoop.of(LOOP, samples)
    form = programme.common(loop, 0.05).form
    assert form is not None
    assert confirm_common(form, loop).holds
    broken = [
        replace(form, form=replace(form.form, P=flipped(form.form.P))),
        replace(form, form=replace(form.form, popov=-1.0)),
        replace(form, multipliers=form.multipliers[:1]),
        replace(form, multipliers=()),
        replace(form, slopes=(0.1, 0.36)),
        replace(form, decay=0.3),
    ]
    for other in broken:
        assert not confirm_common(other, loop).holds


def test_the_check_sees_a_loop_that_the_function_was_not_made_for() -> None:
    form = programme.line(FixedLawLoop.of(LOOP, 50), SLOPE, 0.15).form
    assert form is not None
    for other in (
        replace(LOOP, Ki=50.0),
        replace(LOOP, k_fast=90.0),
        replace(LOOP, Tw=1.0),
        replace(LOOP, dt=0.01),
    ):
        assert not confirm_line(form, FixedLawLoop.of(other, 50)).holds
    assert not confirm_line(form, FixedLawLoop.of(LOOP, 80)).holds


def test_a_solver_that_lies_is_not_believed(monkeypatch: pytest.MonkeyPatch) -> None:
    def lies(self: Any) -> Any:
        return np.random.default_rng(3).normal(size=self.unknowns.count), 1.0, "LIAR"

    monkeypatch.setattr(programme.Program, "solve", lies)
    loop = FixedLawLoop.of(LOOP, 50)
    for found in (programme.line(loop, SLOPE, 0.1), programme.common(loop, 0.01)):
        assert found.form is None
        assert isinstance(found.reason, NotConfirmed)


def test_slopes_at_will_have_no_function_where_memory_has_one() -> None:
    """At (3.13, 10.4) Popov's kind ends; the memory is what rules the bad orders of switching out."""
    loop = FixedLawLoop.of(LoopModel.of(Wrist.flexion(), PI(3.13, 10.4)), 50)
    assert isinstance(programme.common(loop, 1e-3).reason, NoneOfThisKind)
    assert programme.line(loop, SLOPE, 0.2).form is not None


def test_the_growth_of_a_sample_is_at_least_that_of_the_rate() -> None:
    """Also in the digits that floats do not have: proofs in fractions go on from it."""
    for decay in (0.0, 0.1, 0.3, *np.linspace(0.5, 7.0, 20)):
        growth = growth_of(float(decay), 0.001)
        least = Fraction(Decimal(float(decay) * 0.001).exp(Context(prec=60)))
        assert least <= growth <= least + Fraction(1, 10**13)
        assert growth.denominator < 10**14


@pytest.mark.parametrize("scale", [1, 3])
def test_what_is_under_way_loses_what_arrives_and_what_time_takes(scale: int) -> None:
    """Of dt sum_i (S + R (N + 1 - i) dt) u[k-i]^2 over N samples, whose sum of u^2 the moments bound,
    whatever the size of the orthogonal polynomials that they are taken with."""
    loop = FixedLawLoop.of(LOOP, 50)
    made = programme.line(loop, SLOPE, 0.15).form
    assert made is not None
    loop = replace(loop, window=replace(loop.window, size=tuple(scale * s for s in loop.window.size)))
    S, R, dt, N = 0.7, 0.3, LOOP.dt, loop.samples
    form = replace(made.line, P=np.zeros_like(made.line.P), popov=0.0, S=S, R=R)
    step = loop.steps(SLOPE)[0]
    fall = np.asarray(_fall(form, loop, step, 0.0, 0.0), float)
    rows = loop.rows(step, growth_of(0.0, dt))
    kept = [k for k in range(loop.size) if k != loop.states]
    for w in np.random.default_rng(4).standard_normal((5, loop.size)):
        w[loop.states] = 0.0  # F, which this function does not know
        sent, arrived = (float(np.asarray(r, float) @ w) for r in (rows.sent, rows.arrived))
        squares = N * sum(float(w[3 + j]) ** 2 / float(s) for j, s in enumerate(loop.window.size))
        expected = dt * ((S + R * N * dt) * sent**2 - S * arrived**2) - R * dt**2 * squares
        assert w[kept] @ fall @ w[kept] * dt == pytest.approx(expected, rel=1e-9)
        of_states = w[: loop.states]
        assert of_states @ below(form, loop) @ of_states == pytest.approx(S * dt * squares, rel=1e-9)


@pytest.mark.parametrize("samples", [0, 5])
def test_a_sample_is_the_loop_written_out(samples: int) -> None:
    """State, moments of what is under way, distance from the line; the growth of a decay is taken out."""
    loop = FixedLawLoop.of(LOOP, samples)
    dt, g = LOOP.dt, growth_of(0.4, LOOP.dt)
    step = replace(loop.steps(SLOPE)[0], gain=1.3)
    rows, random = loop.rows(step, g), np.random.default_rng(8)
    e, d, q, F, psi = random.normal(size=5) * [3.0, 3.0, 10.0, 5.0, 40.0]
    growth, late = float(g), random.normal(size=samples) * 20.0  # under way, the last sent first
    table = np.asarray(loop.window.table, float)

    def vector(x: list[float], under_way: Any, distance: float) -> list[float]:
        scaled = [u * growth ** -(i + 1) for i, u in enumerate(under_way)]
        moments = [float(row[: len(scaled)] @ scaled) / samples for row in table] if samples else []
        return [*x, *moments, distance]

    phi = float(loop.law.low) * q + dt * psi
    dy = (1.0 - step.keep) * d + step.after * step.slope * phi
    sent = 1.3 * (LOOP.Kp * -dy / dt + LOOP.Ki * e)
    arrives = float(late[-1]) if samples else sent
    w = np.array([*vector([e, d, q], late, F), psi, *([arrives * growth**-samples] if samples else [])])
    after = vector(
        [e - dy, d + step.slope * phi - dy, q - phi + dt * arrives], [sent, *late[:-1]][:samples], F - phi
    )
    expected = np.array([growth * x for x in after])
    np.testing.assert_allclose(np.asarray(rows.now, float) @ w, w[: loop.states + 1], rtol=1e-12)
    np.testing.assert_allclose(np.asarray(rows.after, float) @ w, expected, rtol=1e-9)
    assert float(np.asarray(rows.sent, float) @ w) == pytest.approx(sent)
    assert float(np.asarray(rows.moved, float) @ w) == pytest.approx(arrives - phi / dt)
    rough = loop.rows(step, g, floats=True)
    np.testing.assert_allclose(np.asarray(rough.after), np.asarray(rows.after, float), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("decay", [0.0, 0.7])
def test_what_the_integral_of_the_law_gains_is_bounded_and_hardly_overstated(decay: float) -> None:
    """Of g^2 int_0^(q+) psi - int_0^q psi, twice: exact for the steepest straight law but for what the
    integral so far is overstated by, and never below for the law of the regulator itself."""
    loop = FixedLawLoop.of(LOOP, 0)
    made = programme.common(loop, 0.05).form
    assert made is not None
    g, dt, law = growth_of(decay, LOOP.dt), LOOP.dt, loop.law
    form = replace(made.form, P=np.zeros_like(made.form.P), popov=2.0, S=0.0, R=0.0)
    step = loop.steps(SLOPE)[0]
    rows = loop.rows(step, g)
    fall = np.asarray(_fall(form, loop, step, 0.0, decay), float) * dt
    sector = np.asarray(_fall(form, loop, step, 3.0, decay), float) * dt - fall
    kept = [k for k in range(loop.size) if k != loop.states]
    steepest, high = (float(x - law.low) / dt for x in (law.steepest, law.high))
    c = regulator.sampled(Wrist.flexion().regulator, dt)
    for e, d, q in np.random.default_rng(9).normal(size=(20, 3)) * [3.0, 3.0, 15.0]:
        share = float(regulator.share(q, c)) - float(law.low)
        for psi, of in ((steepest * q, lambda x: steepest * x), (share * q / dt, None)):
            w = np.array([e, d, q, 0.0, psi])
            beyond = q + dt * float(np.asarray(rows.moved, float) @ w)
            psi_of = of or (lambda x: (float(regulator.share(x, c)) - float(law.low)) * x / dt)
            before, after = (quad(psi_of, 0.0, x)[0] for x in (q, beyond))
            told, true = w[kept] @ fall @ w[kept], 2.0 * 2.0 * (float(g) ** 2 * after - before)
            assert told >= true - 1e-9 * abs(true)
            if of is not None:
                overstated = 2.0 * (float(g) ** 2 - 1.0) * (2.0 * psi * q - steepest * q**2)
                assert told - true == pytest.approx(overstated, rel=1e-6, abs=1e-9 * abs(before))
            assert w[kept] @ sector @ w[kept] == pytest.approx(2.0 * 3.0 * dt * psi * (high * q - psi))
