"""A PI of largest integral gain under limits on sensitivities, noise and dead time, by convex programs.

With C = Kp + Ki T/(z - 1) the open loop L = C G is linear in the gains.  At every frequency of a grid,
on every branch and at both regulator rates,

    |1 + L| >= 1/Ms,    |L + Mt^2/(Mt^2 - 1)| >= Mt/(Mt^2 - 1),    |C| <= noise_gain |1 + L|,

and, so that the loop is stable with the dead time on top, |1 + L exp(-i omega delay)| > 0.  The size of
a complex number on the larger side is concave in nothing, but at least its part along the direction that
it had at the last iterate: with that in its place the program is convex, its solution holds the limits
exactly, and each iterate is feasible for the next.  As every frequency keeps to its side of -1, the loop
stays as stable as the first was; where nothing but that is asked, -1 must not slip through between two
points of the grid, so that a distance is kept which comes down, in stages, to what the grid resolves.
Largest Ki is least integrated error after a step of load.

Hast, Astrom, Bernhardsson & Boyd, PID design by convex-concave optimization, Proc. European Control
Conference 2013, p. 4460.  The optimum is local.  The limits that only a
simulation shows (overshoot, total variation of the command, steady error) are not convex: they are met
afterwards.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.controllers.pi import PI
from design.margins import BranchResponse, branch_responses
from design.synthesis.convex import solve
from design.synthesis.evaluate import Evaluation, controller, evaluate
from design.synthesis.requirements import Limits, Problem

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

NOISE_GAIN = 0.8
"""Largest gain [V/deg] from noise of the angle to the command: 0.05 deg of it, at whatever frequency, move
the command by no more than 1 % of its range.  Assumed."""

STAGES = (0.4, 0.1, 0.03)
"""Distances from -1 kept, one after the other, by a loop of which nothing but stability is asked; the
last, which `Rows.least` gives, is what the grid resolves."""

POINTS = 3200
"""Frequencies of the grid."""

CLOSE = 1e-4
"""Share of Ki by which an iteration must raise it to be followed by another."""

MOST = 100
"""Iterations after which it ends in any case; they are feasible all the way."""


@dataclass(frozen=True)
class Shape:
    """Limits on a linear loop: peaks of S and T, both above 1; noise gain [V/deg]; dead time [s] on top
    that must leave it stable.  None drops one."""

    Ms: float | None = 2.0
    Mt: float | None = 2.0
    noise_gain: float | None = NOISE_GAIN
    delay_margin_s: float | None = 0.060

    @classmethod
    def of(cls, limits: Limits) -> "Shape":
        """The limits of a tuning problem, the bound of S taken for T as well."""
        return cls(limits.Ms, limits.Ms, NOISE_GAIN, limits.delay_margin_s)


@dataclass(frozen=True)
class Shaped:
    """Gains of largest Ki that were found: Kp [kPa/deg], Ki [kPa/(deg s)], in how many iterations, by
    which solver, and which limits are active (within 1 %) there."""

    Kp: float
    Ki: float
    iterations: int
    active: tuple[str, ...]
    solver: str


@dataclass(frozen=True)
class Rows:
    """The distinct responses of a plant [deg/kPa] at omega [rad/s], (n, 1) or (1, n) and (m, n), and the
    integrator's T/(z - 1) there, (1, n)."""

    omega: Array
    plant: Complex
    integral: Complex

    @classmethod
    def of(cls, branches: Sequence[BranchResponse], gain: float) -> "Rows":
        """Of branches and the regulator's gain [kPa/V] as the controller knows it."""
        omega = branches[0].omega[None]
        distinct: list[Complex] = []
        for b in branches:
            if not any(np.allclose(b.response, d, rtol=1e-12, atol=0.0) for d in distinct):
                distinct.append(b.response)
        dt = branches[0].dt
        return cls(omega, np.array(distinct) / gain, dt / (np.exp(1j * omega * dt) - 1.0))

    def controller(self, Kp: Any, Ki: Any) -> Complex:
        """Response [kPa/deg] of a PI, (..., 1, n) for gains of shape (..., 1, 1)."""
        return np.asarray(Kp + Ki * self.integral, complex)

    @property
    def least(self) -> float:
        """Distance from -1 at which a response cannot step over it between neighbours of the grid: three
        times their ratio's logarithm, as loops rise and turn no faster there."""
        return 3.0 * float(np.log(self.omega[0, 1] / self.omega[0, 0]))

    def late(self, delay: float) -> Complex:
        """What a dead time [s] does to a response, (1, n)."""
        return np.asarray(np.exp(-1j * self.omega * delay), complex)


def excesses(
    rows: Rows, shape: Shape, gain: float, Kp: Any, Ki: Any, least: float | None = None
) -> dict[str, Array]:
    """By how much gains of shape (...) exceed each limit on the grid, as a share of it; not above 0 where
    it is held.  Of the dead time it is by how much the loop behind it comes nearer to -1 than `least`."""
    at = (np.asarray(k, float)[..., None, None] for k in np.broadcast_arrays(Kp, Ki))
    c = rows.controller(*at)
    loop = c * rows.plant
    away = np.abs(1.0 + loop)
    found: dict[str, Array] = {}
    if shape.Ms is not None:
        found["Ms"] = (1.0 / away).max((-2, -1)) / shape.Ms - 1.0
    if shape.Mt is not None:
        found["Mt"] = (np.abs(loop) / away).max((-2, -1)) / shape.Mt - 1.0
    if shape.noise_gain is not None:
        found["noise_gain"] = (np.abs(c) / away).max((-2, -1)) / (shape.noise_gain * gain) - 1.0
    if shape.delay_margin_s is not None:
        away = np.abs(1.0 + loop * rows.late(shape.delay_margin_s))
        found["delay_margin_s"] = (rows.least if least is None else least) - away.min((-2, -1))
    return found


def largest_Ki(branches: Sequence[BranchResponse], gain: float, shape: Shape | None = None) -> Shaped:
    """Gains of largest Ki [kPa/(deg s)] that hold limits on the linear loop, on a grid of frequencies.

    `branches` as of `design.margins.branch_responses`, gain [kPa/V] as the controller knows it.  Starts
    from gains that are low enough to hold the limits, whatever the plant.  Raises
    design.synthesis.convex.Unsolved
    where no solver comes to an end, ValueError for a limit on a peak that is not above 1.

    >>> from plants import Wrist
    >>> from design.margins import branch_responses
    >>> wrist = Wrist.flexion()
    >>> found = largest_Ki(branch_responses(wrist, POINTS), wrist.regulator.gain)
    >>> round(found.Kp, 1), round(found.Ki, 1), found.active
    (12.0, 27.8, ('noise_gain', 'delay_margin_s'))
    """
    shape = shape or Shape()
    for name, peak in (("Ms", shape.Ms), ("Mt", shape.Mt)):
        if peak is not None and not peak > 1.0:
            raise ValueError(f"{name} = {peak:g}: a peak of a sensitivity is limited to more than 1")
    rows = Rows.of(branches, gain)
    at = _low_gains(rows, shape, gain)
    used: list[NDArray[np.intp]] = []
    solver, iterations = "", 0
    for least in (*(x for x in STAGES if x > rows.least), rows.least):
        raised = True
        while raised and iterations < MOST:
            then, used, solver = _convex_step(rows, shape, gain, at, least, used)
            raised = then[1] > at[1] * (1.0 + CLOSE)
            at, iterations = max(at, then, key=lambda k: k[1]), iterations + 1
    found = excesses(rows, shape, gain, *at)
    return Shaped(*at, iterations, tuple(n for n, e in found.items() if float(e) > -0.01), solver)


def _low_gains(rows: Rows, shape: Shape, gain: float) -> tuple[float, float]:
    """Gains that meet every limit, and the distances that are kept at first, because they are low."""
    far = replace(shape, Ms=min(shape.Ms or np.inf, 1.0 / STAGES[0]))
    for Ki in 10.0 * 0.5 ** np.arange(40):
        if all(float(e) <= 0.0 for e in excesses(rows, far, gain, 0.1 * Ki, Ki, STAGES[0]).values()):
            return 0.1 * float(Ki), float(Ki)
    raise ValueError("no gains are low enough to hold the limits")


@dataclass(frozen=True)
class Half:
    """Half planes that the gains have to keep to: slope @ (Kp, Ki) + offset >= distance, (n, 2), (n,)."""

    slope: Array
    offset: Array
    distance: float

    def short(self, at: Array) -> Array:
        """By how much gains (2,) fall short of each, (n,)."""
        return np.asarray(self.distance - self.offset - self.slope @ at, float)


def _along(rows: Rows, response: Complex, centre: float, at: tuple[float, float], distance: float) -> Half:
    """Of |centre + C response| >= distance: its part along the direction that it has at some gains."""
    towards = centre + rows.controller(*at) * response
    towards = (towards / np.abs(towards)).conj()
    slope = [(towards * response).real.ravel(), (towards * response * rows.integral).real.ravel()]
    return Half(np.array(slope).T, centre * towards.real.ravel(), distance)


def _convex_step(
    rows: Rows,
    shape: Shape,
    gain: float,
    at: tuple[float, float],
    least: float,
    used: list[NDArray[np.intp]],
) -> tuple[tuple[float, float], list[NDArray[np.intp]], str]:
    """The program about one iterate: its solution, the rows that it needed, and the solver.

    Few of the thousands of rows matter, so that it is solved with some and those that it breaks are
    added, until it breaks none: the solution is that with all of them.
    """
    halves = []
    if shape.Mt is not None:
        square = shape.Mt * shape.Mt - 1.0
        halves.append(_along(rows, rows.plant, shape.Mt**2 / square, at, shape.Mt / square))
    if shape.delay_margin_s is not None:
        halves.append(_along(rows, rows.plant * rows.late(shape.delay_margin_s), 1.0, at, least))
    # Last, stability, which is also what the noise is measured by.
    halves.append(_along(rows, rows.plant, 1.0, at, least if shape.Ms is None else 1.0 / shape.Ms))
    integral = np.broadcast_to(rows.integral, rows.plant.shape).ravel()
    used = used or [np.arange(0, integral.size, 64)] * (len(halves) + 1)
    bound = np.inf if shape.noise_gain is None else shape.noise_gain * gain
    for _ in range(50):
        x, solver = _program(halves, integral, bound, used)
        broken = [h.short(x) for h in halves]
        size = np.abs(x[0] + x[1] * integral) / bound
        broken.append(size - (halves[-1].distance - broken[-1]))
        if max(float(b.max()) for b in broken) <= 1e-7:
            break
        used = [np.union1d(u, np.flatnonzero(b > 1e-8)) for u, b in zip(used, broken, strict=True)]
    return (float(x[0]), float(x[1])), used, solver


def _program(
    halves: list[Half], integral: Complex, bound: float, used: list[NDArray[np.intp]]
) -> tuple[Array, str]:
    """Gains (2,) of largest Ki within the rows in use, and the solver that found them."""
    import cvxpy

    cp: Any = cvxpy
    x = cp.Variable(2, nonneg=True)
    limits = [h.slope[u] @ x + h.offset[u] >= h.distance for h, u in zip(halves, used, strict=False)]
    if np.isfinite(bound):
        here, last = used[-1], halves[-1]
        size = [x[0] + x[1] * integral.real[here], x[1] * integral.imag[here]]
        away = last.slope[here] @ x + last.offset[here]
        limits.append(cp.norm(cp.vstack(size), axis=0) <= bound * away)
    problem = cp.Problem(cp.Maximize(x[1]), limits)
    solver = solve(problem)
    return np.asarray(x.value, float), solver


@dataclass(frozen=True)
class ConvexConcave:
    """A PI by convex-concave optimisation that holds the simulated limits as well.

    shape, shaped: limits of the linear loop and the gains of largest Ki under them; share: of both of
    these gains that is left so that the simulated limits hold too; at: evaluation of what is left, arrays
    of length 1.
    """

    problem: Problem
    shape: Shape
    shaped: Shaped
    share: float
    at: Evaluation

    @property
    def controller(self) -> PI:
        """The controller with the gains that are left."""
        return controller(self.problem, float(self.at.Kp[0]), float(self.at.Ki[0]))

    @property
    def breaks(self) -> tuple[str, ...]:
        """Names of the limits that are broken all the same."""
        return tuple(n for n, e in self.at.excess.items() if e[0] > 0.0)


def convex_concave(problem: Problem, shape: Shape | None = None) -> ConvexConcave:
    """The PI of largest Ki under the linear limits, both gains scaled down together until the simulated
    limits hold as well: the largest share of them that does, to 1 %.

    Where none does it is the share of least excess.  Raises design.synthesis.convex.Unsolved, ValueError as
    `largest_Ki`.
    """
    shape = shape or Shape.of(problem.limits)
    shaped = largest_Ki(branch_responses(problem.wrist, POINTS), float(problem.wrist.regulator.gain), shape)
    low, high = 0.02, 1.0
    for points in (32, 16):  # the second time between the largest share that holds and the next
        shares = np.geomspace(low, high, points)
        at = evaluate(problem, shaped.Kp * shares, shaped.Ki * shares)
        held = np.flatnonzero(at.feasible)
        chosen = int(held[-1]) if held.size else int(np.argmin(at.worst_excess))
        low, high = float(shares[chosen]), float(shares[min(chosen + 1, points - 1)])
    return ConvexConcave(problem, shape, shaped, low, at.only(chosen))
