"""Functions of `form` as convex programs: the largest margin by which every inequality holds.

The inequalities are those of `check`, in floats, over a vector scaled so that the loop's matrices are
balanced, as arrays that are linear in the `unknowns`.  What a solver says is never the last word.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.robustness.certificates.memory.check import Confirmation, confirm_common, confirm_line
from design.robustness.certificates.memory.form import CommonForm, LineForm, MemorySearch, WindowForm
from design.robustness.certificates.memory.loop import FixedLawLoop, OneSample, growth_of
from design.robustness.certificates.memory.unknowns import MemoryUnknowns, Program, UnknownForm
from design.robustness.certificates.reasons import NoneOfThisKind, NoSolver, NotConfirmed
from design.synthesis import convex

Array = NDArray[np.float64]

CLAIMED = 1e-7
"""Margin from which a solver's claim is believed for a while: some ten times what it leaves open."""


@dataclass(frozen=True)
class Visited:
    """States that a function is to be small at: w (count, n), the two sums of what is under way (count,) as
    `region.level` has them, F [kPa] (count,)."""

    w: Array
    window: tuple[Array, Array]
    F: Array


def common(loop: FixedLawLoop, decay: float, sure: bool = True) -> MemorySearch:
    """One function for slopes that change at every sample, with a decay [1/s], confirmed, or why not;
    where it need not be `sure`, as the solver claims it."""
    ends = loop.plants.extremes
    u = MemoryUnknowns(loop.states, forms=1, numbers=len(ends))
    form, multipliers = u.form(), [u.number() for _ in ends]
    falls = [
        _fall(loop, decay, form, step, m)
        for s, m in zip(ends, multipliers, strict=True)
        for step in loop.steps([s])
    ]
    least = _least(loop, form)

    def found(x: Array) -> CommonForm:
        numbers = tuple(_multiplier(loop, x @ m) for m in multipliers)
        return CommonForm(_unscaled(loop, form, x), ends, numbers, decay)

    p = Program(u, [*falls, least], size=_size(loop, form))
    return _searched(p, found, (lambda f: confirm_common(f, loop)) if sure else None)


def line(
    loop: FixedLawLoop,
    outer: tuple[float, ...],
    decay: float,
    visited: Visited | None = None,
    sure: bool = True,
) -> MemorySearch:
    """A function for a line of slopes [deg/kPa] and the transit, with a decay [1/s], confirmed, or why not;
    sure: as in `common`.

    The one of widest margin; or, of states that are `visited`, the one that is least there among those that
    tell as much of the static angle: V >= (h - r)^2.
    """
    n, inner = loop.states, loop.plants.inner
    u = MemoryUnknowns(n, forms=2, numbers=n + 4)
    on, far, cross, gap = u.form(), u.form(), u.vector(n), u.number()
    multipliers = [u.number() for _ in range(3)]
    outside, inside = loop.steps(outer), loop.steps(inner)
    falls = [
        *(_fall(loop, decay, on, step, multipliers[0]) for step in outside),
        *(_fall(loop, decay, on, step, multipliers[1], cross, gap) for step in inside),
        *(_fall(loop, decay, far, step, multipliers[2]) for step in inside),
    ]
    apart = [on.popov - far.popov, *([on.S - far.S, on.R - far.R] if loop.samples else [])]
    least = _least(loop, far)
    matrices = [*falls, least, _least(loop, on) - least]

    def found(x: Array) -> LineForm:
        scale = sizes(loop)
        forms = _unscaled(loop, on, x), _unscaled(loop, far, x)
        # What a solver leaves a hair out of order is put in order; the check sees what is then claimed.
        lower = (min(getattr(f, name) for f in forms) for name in ("popov", "S", "R"))
        a, b, c = (_multiplier(loop, x @ m) for m in multipliers)
        return LineForm(
            forms[0], WindowForm(forms[1].P, *lower), (x @ cross) / (scale[:n] * scale[n]),
            max(float(x @ gap), 0.0) / scale[n] ** 2, inner, outer, (a, b, c), decay,
        )  # fmt: skip

    confirm = (lambda f: confirm_line(f, loop)) if sure else None
    size = _size(loop, on)
    if visited is None:
        return _searched(Program(u, matrices, apart, size), found, confirm)
    tells = np.zeros(n)
    tells[:2] = 1.0, -sizes(loop)[1] / sizes(loop)[0]
    at = _at(loop, on, visited, cross, gap), _at(loop, far, visited)
    p = Program(u, matrices, apart, size, floor=(least, np.outer(tells, tells)), at=at)
    return _searched(p, found, confirm)


def _searched(
    p: Program, found: Callable[[Array], Any], confirm: Callable[[Any], Confirmation] | None
) -> MemorySearch:
    try:
        x, claimed, solver = p.solve()
    except convex.Unsolved as error:
        return MemorySearch(None, None, "", NoSolver(str(error)))
    if confirm is None:
        if claimed > CLAIMED:
            return MemorySearch(found(x), claimed, solver)
        return MemorySearch(None, None, solver, NoneOfThisKind(solver, claimed))
    form = found(x)
    said = confirm(form)
    if said.holds:
        return MemorySearch(form, said.margin, solver)
    if claimed <= 0.0:
        return MemorySearch(None, said.margin, solver, NoneOfThisKind(solver, claimed))
    return MemorySearch(None, said.margin, solver, NotConfirmed(solver, said.margin))


def sizes(loop: FixedLawLoop) -> Array:
    """Sizes of the entries of the vector where those of (e, d, q) balance the loop's matrices, (size,)."""
    from scipy.linalg import matrix_balance

    m = loop.model
    slopes = (min(m.slopes.values()), max(m.slopes.values()))
    total = sum(np.abs(m.matrix(s, k)) for s in slopes for k in (m.k_slow, m.k_fast))
    _, (of_x, _) = matrix_balance(total, permute=False, separate=True)
    z = max(m.Ki * float(of_x[0]) + m.Kp / m.Tw * float(of_x[1]), 1e-9)
    late = [z] * int(loop.samples > 0)
    return np.array([*of_x, *[z] * loop.moments, of_x[2], _steep(loop) * float(of_x[2]), *late])


def _steep(loop: FixedLawLoop) -> float:
    """Size of psi/q [1/s]."""
    return max(loop.sector, 1e-9)


def _least(loop: FixedLawLoop, form: UnknownForm) -> Array:
    """What the function is not below, as a quadratic form of w."""
    window = np.diag([0.0] * 3 + [1.0] * loop.moments)
    return form.P + loop.span * form.S[:, None, None] * window


def _size(loop: FixedLawLoop, form: UnknownForm) -> Array:
    """The trace of what a function is not below, and of what it has of the window."""
    trace = np.trace(_least(loop, form), axis1=1, axis2=2)
    return np.asarray(trace + loop.span * (form.S + loop.span * form.R))


def _fall(
    loop: FixedLawLoop, decay: float, form: UnknownForm, step: OneSample, multiplier: Array,
    cross: Array | None = None, gap: Array | None = None,
) -> Array:  # fmt: skip
    """By how much the function falls in a sample, less the sector's share of it, as `check` has it."""
    n, dt, scale = loop.states, loop.model.dt, sizes(loop)
    g = growth_of(decay, dt)
    r = loop.rows(step, g, floats=True)
    known, P = n, form.P
    if cross is not None and gap is not None:
        known = n + 1
        P = np.zeros((len(form.P), known, known))
        P[:, :n, :n], P[:, :n, n], P[:, n, :n], P[:, n, n] = form.P, cross, cross, -gap
    kept = [k for k in range(loop.size) if k != n or known > n]

    def row(a: Array, unit: float = 1.0) -> Array:
        return np.asarray(a[..., kept] * scale[kept] / unit, float)

    def times(number: Array, matrix: Array) -> Array:
        return number[:, None, None] * matrix

    now, moved = (row(a[:known]) / scale[:known, None] for a in (r.now, (r.after - r.now) / dt))
    drift = now.T @ P @ moved
    total = drift + drift.transpose(0, 2, 1) + dt * (moved.T @ P @ moved)
    if loop.samples:
        sent, arrived = row(r.sent, scale[-1]), row(r.arrived, scale[-1])
        window = np.diag([0.0] * 3 + [1.0] * loop.moments + [0.0] * (len(kept) - n))
        total = total + times(form.S + loop.span * form.R, np.outer(sent, sent))
        total = total - times(form.S, np.outer(arrived, arrived)) - times(loop.span * form.R, window)
    psi, q, dq = row(r.psi, _steep(loop) * scale[2]), row(r.q, scale[2]), row(r.moved, scale[2])
    bend = float(loop.law.steepest - loop.law.low) / dt / _steep(loop)
    popov = float(g) ** 2 * (_twice(psi, dq) + dt * bend * np.outer(dq, dq))
    popov = popov + (float(g) ** 2 - 1.0) / dt * (_twice(psi, q) if loop.law.grows else np.outer(q, q))
    total = total + times(form.popov, popov)
    return np.asarray(-total - times(multiplier, _twice(psi, q) - 2.0 * np.outer(psi, psi)))


def _at(
    loop: FixedLawLoop,
    form: UnknownForm,
    visited: Visited,
    cross: Array | None = None,
    gap: Array | None = None,
) -> Array:
    """The function at visited states, (unknowns, states), over the square of the size of e."""
    n, scale = loop.states, sizes(loop)
    w, F = visited.w / scale[:n] / scale[0], visited.F / scale[n] / scale[0]
    total = np.einsum("ki,uij,kj->uk", w, form.P, w)
    total += 2.0 * np.outer(form.popov, w[:, 2] ** 2)
    for number, held in zip((form.S, form.R), visited.window, strict=True):
        total += np.outer(number, held / scale[-1] ** 2 / scale[0] ** 2) if loop.samples else 0.0
    if cross is not None and gap is not None:
        total += 2.0 * F * (cross @ w.T) - np.outer(gap, F**2)
    return np.asarray(total)


def _unscaled(loop: FixedLawLoop, form: UnknownForm, x: Array) -> WindowForm:
    """A function in the loop's units; numbers that a solver leaves a hair below 0 are 0."""
    scale = sizes(loop)
    P = np.tensordot(x, form.P, 1) / np.outer(scale[: loop.states], scale[: loop.states])
    popov, S, R = (max(float(x @ a), 0.0) for a in (form.popov, form.S, form.R))
    late = (S / scale[-1] ** 2, R / scale[-1] ** 2) if loop.samples else (0.0, 0.0)
    return WindowForm(0.5 * (P + P.T), popov / (_steep(loop) * scale[2] ** 2), *late)


def _multiplier(loop: FixedLawLoop, value: Any) -> float:
    """A multiplier of the sector in the loop's units."""
    return max(float(value), 0.0) / (_steep(loop) * float(sizes(loop)[2])) ** 2


def _twice(a: Array, b: Array) -> Array:
    return np.outer(a, b) + np.outer(b, a)
