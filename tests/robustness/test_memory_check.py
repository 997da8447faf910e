"""The check of functions with memory decides in fractions, and refuses what was tampered with."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from design.controllers.pi import PI
from design.robustness.certificates.memory import programme
from design.robustness.certificates.memory.check import _fall, below, confirm_common, confirm_line
from design.robustness.certificates.memory.loop import FixedLawLoop, growth_of
from design.robustness.certificates.reasons import NoneOfThisKind, NotConfirmed
from design.robustness.loop_model import LoopModel
from plants import Wrist

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
    for decay in (0.0, 0.1, 0.3, 7.0):
        assert float(growth_of(decay, 0.001)) >= np.exp(decay * 0.001)
        assert float(growth_of(decay, 0.001)) <= np.exp(decay * 0.001) + 1e-12


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
