"""Functions of `form` as convex programs: the largest margin by which every inequality holds.

The inequalities are those of `check`, in floats, over a vector scaled so that the loop's matrices are
balanced.  What a solver says of them is never the last word.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.robustness.certificates.memory.check import Confirmation, confirm_common, confirm_line
from design.robustness.certificates.memory.form import CommonForm, LineForm, MemorySearch, WindowForm
from design.robustness.certificates.memory.loop import FixedLawLoop, growth_of
from design.robustness.certificates.reasons import NoneOfThisKind, NoSolver, NotConfirmed
from design.synthesis import convex

Array = NDArray[np.float64]

LEAST_MARGIN = 1e-6
"""By how much every inequality has to hold, as a share of the function's size, where that is not the goal."""

CLAIMED = 1e-7
"""Margin from which a solver's claim is believed for a while: some ten times what it leaves open."""


@dataclass
class _Program:
    """Variables and constraints of one search; `margin`: what every inequality holds by."""

    loop: FixedLawLoop
    decay: float
    scale: Array
    margin: Any
    constraints: list[Any] = field(default_factory=list)
    goal: Any = None

    @classmethod
    def of(cls, loop: FixedLawLoop, decay: float) -> "_Program":
        import cvxpy

        return cls(loop, decay, sizes(loop), cvxpy.Variable())

    def form(self) -> "_Form":
        """A new function."""
        import cvxpy

        n, late = self.loop.states, self.loop.samples > 0
        numbers = [cvxpy.Variable(nonneg=True) if there else 0.0 for there in (True, late, late)]
        return _Form(cvxpy.Variable((n, n), symmetric=True), *numbers)

    def least(self, form: "_Form") -> Any:
        """What the function is not below, as a quadratic form of w."""
        return form.P + self.loop.span * form.S * np.diag([0.0] * 3 + [1.0] * self.loop.moments)

    def fall(self, form: "_Form", slope: float, cross: Any = None, gap: Any = None) -> Any:
        """The function falls on a slope; the multiplier of the sector that shows it."""
        import cvxpy

        loop, scale = self.loop, self.scale
        n, dt = loop.states, loop.model.dt
        g = growth_of(self.decay, dt)
        r = loop.rows(slope, g, floats=True)
        known = n if cross is None else n + 1
        kept = [k for k in range(loop.size) if cross is not None or k != n]

        def row(a: Array, unit: float = 1.0) -> Array:
            return np.asarray(a[..., kept] * scale[kept] / unit, float)

        now, moved = (row(a[:known]) / scale[:known, None] for a in (r.now, (r.after - r.now) / dt))
        P = form.P
        if cross is not None:
            P = cvxpy.bmat([[P, cross], [cross.T, -cvxpy.reshape(gap, (1, 1), order="C")]])
        total = now.T @ P @ moved
        total = total + total.T + dt * (moved.T @ P @ moved)
        z = scale[-1]
        if loop.samples:
            sent, arrived = row(r.sent, z), row(r.arrived, z)
            window = np.zeros((len(kept), len(kept)))
            window[range(3, n), range(3, n)] = 1.0
            total = total + (form.S + form.R * loop.span) * np.outer(sent, sent)
            total = total - form.S * np.outer(arrived, arrived) - form.R * loop.span * window
        multiplier = cvxpy.Variable(nonneg=True)
        unit = max(loop.sector, 1e-9) * scale[2]
        psi, q, dq = row(r.psi, unit), row(r.q, scale[2]), row(r.moved, scale[2])
        bend = float(loop.law.steepest - loop.law.low) / dt / max(loop.sector, 1e-9)
        popov = float(g) ** 2 * (_twice(psi, dq) + dt * bend * np.outer(dq, dq))
        share = _twice(psi, q) if loop.law.grows else np.outer(q, q)
        popov = popov + (float(g) ** 2 - 1.0) / dt * share
        total = total + form.popov * popov + multiplier * (_twice(psi, q) - 2.0 * np.outer(psi, psi))
        self.constraints.append((total + total.T) / 2.0 << -self.margin * np.eye(len(kept)))
        return multiplier

    def at(self, form: "_Form", visited: "Visited", cross: Any = None, gap: Any = None) -> Any:
        """The function at visited states, (count,), over the square of the size of e."""
        import cvxpy

        n, unit = self.loop.states, self.scale[0] ** 2
        w, F, z = visited.w / self.scale[:n], visited.F / self.scale[n], self.scale[-1]
        integral = visited.w[:, 2] ** 2 / self.scale[2] ** 2
        total = cvxpy.sum(cvxpy.multiply(w @ form.P, w), axis=1) + 2.0 * form.popov * integral
        if self.loop.samples:
            total = total + (form.S * visited.window[0] + form.R * visited.window[1]) / z**2
        if cross is not None:
            total = total + 2.0 * cvxpy.multiply(F, (w @ cross)[:, 0]) - gap * F**2
        return total / unit

    def solve(self, size: Any) -> str:
        """The solver that came to the goal, or to the widest margin at a size of the function; raises
        `convex.Unsolved`."""
        import cvxpy

        whole = self.constraints if size is None else [*self.constraints, size == float(self.loop.states)]
        goal = self.margin if self.goal is None else self.goal
        return convex.solve(cvxpy.Problem(cvxpy.Maximize(goal), whole))

    def unscaled(self, form: "_Form") -> WindowForm:
        """What the solver left of a function, in the loop's units."""
        size, z = self.scale[: self.loop.states], self.scale[-1]
        P = np.asarray(form.P.value, float) / np.outer(size, size)
        late = (_number(x) / z**2 for x in (form.S, form.R))
        return WindowForm(0.5 * (P + P.T), _number(form.popov) * self.of_sector(), *late)

    def of_sector(self) -> float:
        """1 / (psi q) of the scaled vector in the loop's units."""
        return 1.0 / (max(self.loop.sector, 1e-9) * self.scale[2] ** 2)

    def of_multiplier(self) -> float:
        """1 / psi^2 likewise."""
        return self.of_sector() / max(self.loop.sector, 1e-9)


@dataclass(frozen=True)
class _Form:
    """A `WindowForm` of cvxpy's variables, over the scaled vector."""

    P: Any
    popov: Any
    S: Any
    R: Any


def sizes(loop: FixedLawLoop) -> Array:
    """Sizes of the entries of the vector where those of (e, d, q) balance the loop's matrices, (size,)."""
    from scipy.linalg import matrix_balance

    m = loop.model
    slopes = (min(m.slopes.values()), max(m.slopes.values()))
    total = sum(np.abs(m.matrix(s, k)) for s in slopes for k in (m.k_slow, m.k_fast))
    _, (of_x, _) = matrix_balance(total, permute=False, separate=True)
    z = max(m.Ki * float(of_x[0]) + m.Kp / m.Tw * float(of_x[1]), 1e-9)
    law = max(loop.sector, 1e-9) * float(of_x[2])
    late = [z] * int(loop.samples > 0)
    return np.array([*of_x, *[z] * loop.moments, of_x[2], law, *late])


def common(loop: FixedLawLoop, decay: float, sure: bool = True) -> MemorySearch:
    """One function for slopes that change at every sample, with a decay [1/s], confirmed, or why not; where it
    need not be `sure`, as the solver claims it, which takes half the time."""
    p = _Program.of(loop, decay)
    form = p.form()
    slopes = sorted(set(loop.model.slopes.values()))
    slopes = sorted({slopes[0], slopes[-1]})
    multipliers = [p.fall(form, s) for s in slopes]
    p.constraints.append(p.least(form) >> p.margin * np.eye(loop.states))

    def found() -> CommonForm:
        numbers = tuple(_number(m) * p.of_multiplier() for m in multipliers)
        return CommonForm(p.unscaled(form), tuple(slopes), numbers, decay)

    return _searched(p, _size(p, form), found, (lambda f: confirm_common(f, loop)) if sure else None)


@dataclass(frozen=True)
class Visited:
    """States that a function is to be small at: w (count, n), the two sums of what is under way (count,) as
    `region.level` has them, F [kPa] (count,)."""

    w: Array
    window: tuple[Array, Array]
    F: Array


def line(
    loop: FixedLawLoop, outer: float, decay: float, visited: Visited | None = None, sure: bool = True
) -> MemorySearch:
    """A function for a line of a slope [deg/kPa] and the transit, with a decay [1/s], confirmed, or why not;
    sure: as in `common`.

    The one of widest margin; or, of states that are `visited`, the one that is least there among those that
    tell most of the static angle: V >= (h - r)^2.
    """
    import cvxpy

    p = _Program.of(loop, decay)
    on, far = p.form(), p.form()
    if visited is not None:
        p.margin = LEAST_MARGIN / loop.states * _size(p, on)
    inner, n = min(loop.model.slopes.values()), loop.states
    cross, gap = cvxpy.Variable((n, 1)), cvxpy.Variable(nonneg=True)
    multipliers = [p.fall(on, outer), p.fall(on, inner, cross, gap), p.fall(far, inner)]
    p.constraints += [
        p.least(far) >> p.margin * np.eye(n),
        p.least(on) - p.least(far) >> p.margin * np.eye(n),
        on.popov >= far.popov,
        *([on.S >= far.S, on.R >= far.R] if loop.samples else []),
    ]

    def found() -> LineForm:
        of, F = p.scale[:n], p.scale[n]
        forms = p.unscaled(on), p.unscaled(far)
        on_, leaving, far_ = (_number(m) * p.of_multiplier() for m in multipliers)
        # What a solver leaves a hair out of order is put in order; the check sees what is then claimed.
        lower = (min(getattr(f, x) for f in forms) for x in ("popov", "S", "R"))
        return LineForm(
            forms[0], WindowForm(forms[1].P, *lower), np.asarray(cross.value, float)[:, 0] / (of * F),
            _number(gap) / F**2, inner, outer, (on_, leaving, far_), decay,
        )  # fmt: skip

    confirm = (lambda f: confirm_line(f, loop)) if sure else None
    if visited is None:
        return _searched(p, _size(p, on), found, confirm)
    static = np.zeros(n)
    static[:2] = p.scale[0], -p.scale[1]
    p.constraints.append(p.least(far) >> np.outer(static, static) / p.scale[0] ** 2)
    p.goal = -cvxpy.sum(cvxpy.maximum(p.at(on, visited, cross, gap), p.at(far, visited)))
    return _searched(p, None, found, confirm)


def _size(p: _Program, form: _Form) -> Any:
    """The trace of what a function is not below."""
    least = p.least(form)
    return sum(least[k, k] for k in range(p.loop.states)) + p.loop.span * (form.S + p.loop.span * form.R)


def _searched(
    p: _Program, size: Any, found: Callable[[], Any], confirm: Callable[[Any], Confirmation] | None
) -> MemorySearch:
    try:
        solver = p.solve(size)
    except convex.Unsolved as said:
        return MemorySearch(None, None, "", NoSolver(str(said)))
    claimed = float(p.margin.value)
    if confirm is None and claimed > CLAIMED:
        return MemorySearch(found(), claimed, solver)
    if confirm is None:
        return MemorySearch(None, None, solver, NoneOfThisKind(solver, claimed))
    form = found()
    said = confirm(form)
    if said.holds:
        return MemorySearch(form, said.margin, solver)
    if claimed <= 0.0:
        return MemorySearch(None, said.margin, solver, NoneOfThisKind(solver, claimed))
    return MemorySearch(None, said.margin, solver, NotConfirmed(solver, said.margin))


def _number(variable: Any) -> float:
    """Value of a number that is not negative; 0 where a solver leaves it a hair below."""
    return variable if isinstance(variable, float) else max(float(variable.value), 0.0)


def _twice(a: Array, b: Array) -> Array:
    return np.outer(a, b) + np.outer(b, a)
