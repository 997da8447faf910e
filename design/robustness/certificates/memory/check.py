"""The last word on a function of `form`: every inequality rebuilt from the loop's equations, in fractions.

Nothing that the solver was given is used.  The numbers of the form and the coefficients that the simulator
steps are floats, hence rational, and so is every entry of the matrices here: whether they are definite is
decided without rounding.  The margin tells by how much, as in `certificates.continuous.check`.

A sample changes V exp(2 decay t) by at most D, a quadratic form of the vector, because

    int_q^(q+) psi <= psi (q+ - q) + (steepest - low)/dt (q+ - q)^2 / 2        (psi' is bounded),
    int_0^q psi <= psi q where psi grows with q, else (high - low)/dt q^2 / 2,
    sum_i (u[k - i] ..)^2 >= N sum_j O_j^2 / size_j                            (Bessel's inequality),

and D + 2 multiplier psi ((high - low)/dt q - psi) < 0 makes it fall wherever the sector holds.

Source: sampled functions with the integral of a law whose slope is bounded, K.-K. K. Kim and R. D. Braatz,
arXiv 1509.01302; the moments, A. Seuret and F. Gouaisbaut, Systems & Control Letters 81 (2015) 1-7.
"""

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from design.robustness.certificates.continuous.check import positive
from design.robustness.certificates.memory.form import CommonForm, LineForm, WindowForm
from design.robustness.certificates.memory.loop import FixedLawLoop, OneSample, growth_of
from design.robustness.certificates.memory.rational import Exact, exact, positive_definite, product


@dataclass(frozen=True)
class Confirmation:
    """Whether every inequality holds, exactly, and by how much the worst does, as a share of its own size."""

    holds: bool
    margin: float


def confirm_common(found: CommonForm, loop: FixedLawLoop) -> Confirmation:
    """Whether one function falls on all slopes between the loop's least and largest.

    The next state is affine in the slope, and in each of the other numbers of a sample
    (`FixedLawLoop.steps`), and the function convex in it, so that the corners answer for all between.
    """
    signs = len(found.multipliers) == len(found.slopes) and _numbers(found.decay, *found.multipliers)
    if not (signs and _signs(found.form, loop) and set(loop.plants.extremes) <= set(found.slopes)):
        return Confirmation(False, -1.0)
    parts = [
        -_fall(found.form, loop, step, m, found.decay)
        for s, m in zip(found.slopes, found.multipliers, strict=True)
        for step in loop.steps([s])
    ]
    return _of([*parts, _below(found.form, loop)])


def confirm_line(found: LineForm, loop: FixedLawLoop) -> Confirmation:
    """Whether a function falls along every loop that meets one line only, whatever it does there.

    With F = 0 on the line the two functions of `LineForm` are one.  A sample that begins F before the line
    and ends on it moves a share of its way along the transit: what it adds to V is convex in that share, as
    `gap` is not negative, so that the two whole ways, each a matrix here, answer for it.
    """
    lines = {tuple(sorted(set(ends))) for ends in loop.plants.slopes.values()}
    line, transit = found.line, found.transit
    ordered = line.popov >= transit.popov and line.S >= transit.S and line.R >= transit.R
    numbers = _numbers(found.decay, found.gap, *found.multipliers) and bool(np.isfinite(found.cross).all())
    signs = numbers and _signs(line, loop) and _signs(transit, loop)
    fits = found.cross.shape == (loop.states,) and found.outer in lines
    if not (ordered and signs and fits and found.inner == loop.plants.inner):
        return Confirmation(False, -1.0)
    on, leaving, far = found.multipliers
    outside, inside = loop.steps(found.outer), loop.steps(found.inner)
    cross, gap = exact(found.cross), Fraction(found.gap)
    return _of([
        *(-_fall(line, loop, step, on, found.decay) for step in outside),
        *(-_fall(line, loop, step, leaving, found.decay, cross, gap) for step in inside),
        *(-_fall(transit, loop, step, far, found.decay) for step in inside),
        _below(transit, loop),
        exact(line.P) - exact(transit.P) + _window(loop, Fraction(line.S) - Fraction(transit.S)),
    ])  # fmt: skip


def below(form: WindowForm, loop: FixedLawLoop) -> Any:
    """A matrix Q with w'Q w <= V, from Bessel's inequality; floats (n, n)."""
    return np.asarray(_below(form, loop), float)


def _of(parts: list[Exact]) -> Confirmation:
    margin = min(positive(np.asarray(part, float)) for part in parts)
    return Confirmation(margin > 0.0 and all(positive_definite(part) for part in parts), margin)


def _numbers(*values: float) -> bool:
    """Whether they are finite and not negative."""
    return bool(np.isfinite(values).all()) and min(values) >= 0.0


def _signs(form: WindowForm, loop: FixedLawLoop) -> bool:
    shape = form.P.shape == (loop.states, loop.states) and np.array_equal(form.P, form.P.T)
    return shape and bool(np.isfinite(form.P).all()) and _numbers(form.popov, form.S, form.R)


def _below(form: WindowForm, loop: FixedLawLoop) -> Exact:
    found: Exact = exact(form.P) + _window(loop, Fraction(form.S))
    return found


def _window(loop: FixedLawLoop, weight: Fraction) -> Exact:
    """weight x N dt sum_j O_j^2 / size_j as a matrix (n, n)."""
    found = exact(np.zeros((loop.states, loop.states)))
    for j, size in enumerate(loop.window.size):
        found[3 + j, 3 + j] = weight * loop.samples * Fraction(loop.model.dt) / size
    return found


def _fall(
    form: WindowForm, loop: FixedLawLoop, step: OneSample, multiplier: float, decay: float,
    cross: Exact | None = None, gap: Fraction | None = None,
) -> Exact:  # fmt: skip
    """D and the sector's share of it, over dt, as a matrix; cross, gap: of the function that knows F."""
    dt, law, n = Fraction(loop.model.dt), loop.law, loop.states
    g = growth_of(decay, loop.model.dt)
    r = loop.rows(step, g)
    P = exact(np.zeros((n + 1, n + 1)))
    P[:n, :n] = exact(form.P)
    if cross is not None and gap is not None:
        P[:n, n], P[n, :n], P[n, n] = cross, cross, -gap
    total = product(r.after.T, P, r.after) - product(r.now.T, P, r.now)
    S, R, popov = Fraction(form.S), Fraction(form.R), Fraction(form.popov)
    if loop.samples:
        total = total + dt * ((S + R * loop.samples * dt) * _square(r.sent) - S * _square(r.arrived))
        for j, size in enumerate(loop.window.size):
            total = total - dt * dt * R * loop.samples / size * _square(r.now[3 + j])
    way, bend = dt * r.moved, (law.steepest - law.low) / dt
    total = total + popov * g * g * (_twice(r.psi, way) + bend * _square(way))
    sector = (law.high - law.low) / dt
    integral = _twice(r.psi, r.q) if law.grows else sector * _square(r.q)
    total = total + popov * (g * g - 1) * integral
    total = total + dt * Fraction(multiplier) * (sector * _twice(r.psi, r.q) - 2 * _square(r.psi))
    kept = [k for k in range(loop.size) if cross is not None or k != n]
    found: Exact = (total / dt)[np.ix_(kept, kept)]
    return found


def _square(a: Exact) -> Exact:
    return np.outer(a, a)


def _twice(a: Exact, b: Exact) -> Exact:
    found: Exact = np.outer(a, b) + np.outer(b, a)
    return found
