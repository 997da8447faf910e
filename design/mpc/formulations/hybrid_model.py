"""The wrist over one period as a hybrid linear system: what the MILP (c) knows of it.

Three parts in series, each from one end of a period of T seconds to the other, the command held:

- Regulator.  What goes of the error e = gain v - P in a period depends on e alone (the law is
  autonomous in e), rises with it, and is odd: the integral of k(e) e over the period.  It is
  approximated by a continuous piecewise affine function that agrees with it at knots, and how far the
  two are apart at most is part of the result.
- Hysteresis.  The pressure moves one way within a period and the loop does not depend on how a
  monotonic move is cut, so that `plants.hysteresis.step` over the whole period is exact: three branches
  (line 1, transit, line 2), affine each, and the virgin curve.
- Lag, under the assumption that the static angle goes from one end of the period to the other as the
  pressure does far from the commanded one.  In a period in which a line is met it begins later than that,
  and the angle at the end is overstated in the direction of the move.  The wrist missed the angles of
  plans that were tried by up to 0.14 deg with periods of 20 ms, and 0.33 deg with 40 ms.

Bemporad & Morari, Automatica 35 (1999) 407, doi 10.1016/S0005-1098(98)00178-2.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from design.mpc.problem import MPCProblem
from plants import lag
from plants.actuator import regulator
from plants.errors import InputError
from plants.hysteresis import Memory
from plants.wrist import State

Array = NDArray[np.float64]

GRID = 20_001
"""Errors of pressure at which exact and piecewise affine law are compared, evenly over one side."""


class Piecewise(NamedTuple):
    """An odd, continuous, piecewise affine function of the error of pressure [kPa].

    knots [kPa] (m + 1,), the first being 0; values: pressure gained in a period there [kPa]; error: largest
    difference from the exact law between the knots [kPa]; period [s].
    """

    knots: Array
    values: Array
    error: float
    period: float

    def __call__(self, error: Array | float) -> Array:
        """Pressure gained in a period [kPa], for errors within the knots."""
        return np.asarray(np.sign(error) * np.interp(np.abs(error), self.knots, self.values), float)

    @property
    def rate_error(self) -> float:
        """The largest difference as one of k(e) e [kPa/s], averaged over the period."""
        return self.error / self.period

    @property
    def segments(self) -> list[tuple[float, float, float, float]]:
        """(from, to, slope, intercept) over all errors, in order; the one through 0 is whole."""
        up = [
            (float(a), float(b), float((d - c) / (b - a)), float(c - a * (d - c) / (b - a)))
            for a, b, c, d in zip(
                self.knots[:-1], self.knots[1:], self.values[:-1], self.values[1:], strict=True
            )
        ]
        down = [(-b, -a, slope, -intercept) for a, b, slope, intercept in reversed(up[1:])]
        return [*down, (-up[0][1], up[0][1], up[0][2], 0.0), *up[1:]]


def gained(problem: MPCProblem, error: Array | float) -> Array:
    """Pressure [kPa] that a period gains on an error [kPa] at its start, by the exact law."""
    c = problem.wrist.sampled().regulator
    start = np.asarray(error, float)
    left = start
    for _ in range(problem.substeps):
        left = left - regulator.share(left, c) * left
    return np.asarray(start - left, float)


def piecewise(problem: MPCProblem, most: float, pieces: int) -> Piecewise:
    """The law with so many pieces on either side of 0, up to an error of `most` [kPa].

    Each piece goes as far as a tolerance lets it, and the tolerance is halved in on.  That need not be the
    least largest difference, since the law is first convex, then concave: up to 1.7 times that was seen, with
    two pieces, and 1.2 times with four.  Raises InputError for no pieces.
    """
    if pieces < 1:
        raise InputError(f"hybrid MPC: {pieces} pieces of the regulator's law: give 1 or more")
    grid = np.linspace(0.0, most, GRID)
    exact = gained(problem, grid)
    low, high, at = 0.0, float(np.max(exact)), [0, GRID - 1]
    for _ in range(30):
        middle = 0.5 * (low + high)
        tried = _greedy(grid, exact, middle, pieces)
        low, high, at = (middle, high, at) if tried is None else (low, middle, tried)
    knots, values = grid[at], exact[at]
    between = np.abs(np.interp(grid, knots, values) - exact)
    return Piecewise(knots, values, float(between.max()), problem.period)


def _greedy(grid: Array, exact: Array, tolerance: float, pieces: int) -> list[int] | None:
    """Knots, as indices, of pieces each as long as the tolerance lets it be; None where it takes more."""
    at, last = [0], len(grid) - 1
    while at[-1] < last:
        if len(at) > pieces:
            return None
        begin, fits, fails = at[-1], at[-1] + 1, last + 1
        while fails - fits > 1:  # as if a longer chord always missed more
            end = (fits + fails) // 2
            x = grid[begin : end + 1]
            chord = np.interp(x, [x[0], x[-1]], [exact[begin], exact[end]])
            good = np.max(np.abs(chord - exact[begin : end + 1])) <= tolerance
            fits, fails = (end, fails) if good else (fits, end)
        at.append(fits)
    return at


def sampled_lag(problem: MPCProblem, most: float) -> lag.SampledLag:
    """The lag over a period, the static angle moving as the pressure does on an error of `most` [kPa]."""
    c, fine = problem.wrist.sampled().regulator, problem.wrist.sampled().lag
    left = [most]
    for _ in range(problem.substeps):
        left.append(left[-1] - float(regulator.share(left[-1], c)) * left[-1])
    path = (most - np.array(left)) / (most - left[-1])
    after = 0.0
    for before, then in pairwise(path):
        after = float(lag.step(after, before, then, fine))
    keep = float(fine.keep) ** problem.substeps
    return lag.SampledLag(keep, 1.0 - keep - after, after)


def move(problem: MPCProblem, law: Piecewise, state: State, command: float, lack: float = 0.0) -> State:
    """The wrist of the hybrid model one period of a command [V] later; the regulator's law as given, all
    else as the module says.  With `gained` in its place only the lag would be approximate."""
    p, P = problem.wrist, float(state.pressure)
    after = P + float(law(p.regulator.gain * command + lack - P))
    memory = p.hysteresis.step(state.memory, P, after)
    angle = lag.step(state.angle, state.memory.h, memory.h, sampled_lag(problem, float(law.knots[-1])))
    return State(after, Memory(float(memory.h), float(memory.virgin)), float(angle))


def play(problem: MPCProblem, law: Piecewise, state: State, plan: Array, lack: float = 0.0) -> Array:
    """Angles [deg] at the ends of the periods of a plan [V], by the hybrid model; shape of the plan."""
    angles = np.empty(len(plan))
    for k, command in enumerate(plan):
        state = move(problem, law, state, float(command), lack)
        angles[k] = state.angle
    return angles
