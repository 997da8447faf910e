"""Where a `LineForm` holds: states from which one line at most is met, and the command is not clipped.

V >= w'Q w, of which `transit` and Bessel's inequality give Q, and V falls by growth^-2 a sample.  So from a
state with V <= c, for ever,

    |q| <= sqrt(c g'Q^-1 g) with g'w = q,      |h - r| <= sqrt(c g'Q^-1 g) with g'w = e - d.

The pressure lies between those of the two lines at h; where these, and |q| beyond them, are within the range
of the command, it is not clipped.  On the transit the pressure moves by the change of h over its slope,
2 |h - r| at most; the other line being further away than that, from where the wrist is and from the line that
it may leave later, is not met.  Then the loop is one of those that the function is about, and decays at its
rate.

Steps arrive there by themselves: `arrivals` looks for the moment in runs, which may be clipped and meet both
lines before.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from design.robustness.certificates.memory.check import below
from design.robustness.certificates.memory.form import LineForm, WindowForm
from design.robustness.certificates.memory.loop import FixedLawLoop, growth_of
from design.robustness.certificates.memory.programme import Visited
from design.robustness.certificates.memory.runs import Runs
from plants.hysteresis.law import HysteresisLaw, Side

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

LOOKED_AT = 10
"""Samples between two moments at which a run is looked at."""

SPARE = 0.01
"""Share by which every bound has to hold more than it must, against rounding in the runs."""


@dataclass(frozen=True)
class Arrivals:
    """When each run is within a region for good, [s] after its last reference began, (runs,), infinite where
    it is not by its end; names of the runs; clipped: how many met an end of the range before; error [deg]:
    the most that a static angle is off from then on."""

    time: Array
    names: tuple[str, ...]
    clipped: int
    error: float

    @property
    def all(self) -> bool:
        """Whether every run arrives."""
        return bool(np.isfinite(self.time).all())


def arrivals(forms: Mapping[Side, LineForm], loop: FixedLawLoop, law: HysteresisLaw, runs: Runs) -> Arrivals:
    """The first moment at which each run is in the region of the function of one of the two lines."""
    at = np.arange(0, len(runs.pressure), LOOKED_AT)
    inside = np.zeros((len(at), len(runs.names)), bool)
    error = np.full(inside.shape, np.inf)
    for side, form in forms.items():
        held, off = _within(form, side, loop, law, runs, at)
        error = np.where(held, np.minimum(error, off), error)
        inside |= held
    inside &= at[:, None] >= runs.begins
    there, first = inside.any(axis=0), np.argmax(inside, axis=0)
    lanes = np.arange(len(runs.names))
    time = np.where(there, (at[first] - runs.begins) * loop.model.dt, np.inf)
    clipped = [runs.clipped[: at[k] + 1, lane].any() for k, lane in zip(first, lanes, strict=True)]
    off = error[first, lanes][there]
    return Arrivals(time, runs.names, int(np.sum(clipped)), float(off.max()) if off.size else np.inf)


def visited(
    side: Side, loop: FixedLawLoop, law: HysteresisLaw, runs: Runs, time: float, decay: float
) -> Visited | None:
    """The states of the runs that are nearer to one line than to the other at a time [s] after their last
    reference began; None where there are none."""
    lanes = np.arange(len(runs.names))
    at = np.minimum(runs.begins + round(time / loop.model.dt), len(runs.pressure) - 1)
    w, window = _states(loop, runs, np.unique(at), decay)
    row = np.searchsorted(np.unique(at), at)
    mine, other = _gaps(side, law, runs, at, lanes)
    near = (mine <= other) & runs.left_virgin[at, lanes]
    if not near.any():
        return None
    F = mine / _beyond(law, side)
    sums = tuple(x[row, lanes][near] for x in window)
    return Visited(_sign(side) * w[row, lanes][near], (sums[0], sums[1]), F[near])


def level(form: LineForm, loop: FixedLawLoop, w: Array, window: tuple[Array, Array], F: Array) -> Array:
    """V at most, (..), of states w (.., n), F [kPa] from the line; window: dt sum of (growth^-i u)^2, and of
    the same weighted by (N + 1 - i) dt."""
    integral = loop.sector * w[..., 2] ** 2  # psi q at most

    def of(f: WindowForm) -> Array:
        quadratic = np.einsum("...i,ij,...j->...", w, f.P, w)
        total: Array = quadratic + f.S * window[0] + f.R * window[1] + 2.0 * f.popov * integral
        return total

    near = of(form.line) + 2.0 * F * (w @ form.cross) - form.gap * F * F
    found: Array = np.maximum(near, of(form.transit))
    return found


def _within(
    form: LineForm, side: Side, loop: FixedLawLoop, law: HysteresisLaw, runs: Runs, at: NDArray[np.intp]
) -> tuple[Flags, Array]:
    """Whether each run is in the region of a line at samples, (samples, runs), and the most [deg] that the
    static angle is off from then on."""
    w, window = _states(loop, runs, at, form.decay)
    mine, other = _gaps(side, law, runs, at)
    c = np.maximum(level(form, loop, _sign(side) * w, window, mine / _beyond(law, side)), 0.0)
    inverse = np.linalg.inv(below(form.transit, loop))
    static = np.zeros(loop.states)
    static[:2] = 1.0, -1.0
    q, off = (np.sqrt(c * (g @ inverse @ g)) * (1.0 + SPARE) for g in (np.eye(loop.states)[2], static))
    r = runs.reference[at]
    low = np.minimum(law.descending_pressure(r - off), law.ascending_pressure(r - off))
    high = np.maximum(law.ascending_pressure(r + off), law.descending_pressure(r + off))
    held = (low - q > runs.low) & (high + q < runs.high)
    widths = np.minimum(*(law.descending(p) - law.ascending(p) for p in (low, high)))
    flat = float(law.flattest)
    reach = 2.0 * off / flat if flat > 0.0 else np.full_like(off, np.inf)
    held &= np.minimum(other, widths) > reach * _beyond(law, _OTHER[side])
    held &= runs.left_virgin[at] & ~runs.clipped[at]
    return held, off


_OTHER: dict[Side, Side] = {"ascending": "descending", "descending": "ascending"}


def _sign(side: Side) -> float:
    """The descending line is the ascending one of the loop turned about."""
    return 1.0 if side == "ascending" else -1.0


def _beyond(law: HysteresisLaw, side: Side) -> float:
    """By how much a line is steeper than the transit [deg/kPa]."""
    up, down = law.steepness
    return float(up if side == "ascending" else down) - float(law.flattest)


def _gaps(
    side: Side, law: HysteresisLaw, runs: Runs, at: NDArray[np.intp], lanes: NDArray[np.intp] | None = None
) -> tuple[Array, Array]:
    """How far [deg] the static angle is from a line, and from the other."""
    here = at if lanes is None else (at, lanes)
    P, h = runs.pressure[here], runs.static[here]
    gaps = np.maximum(h - law.ascending(P), 0.0), np.maximum(law.descending(P) - h, 0.0)
    return gaps if side == "ascending" else gaps[::-1]


def _states(
    loop: FixedLawLoop, runs: Runs, at: NDArray[np.intp], decay: float
) -> tuple[Array, tuple[Array, Array]]:
    """w (samples, runs, n) at samples, and the two sums of what is under way."""
    N, dt = loop.samples, loop.model.dt
    e = runs.reference[at] - runs.angle[at]
    before = np.where((at >= N)[:, None], runs.command[np.maximum(at - N, 0)], runs.rest)
    parts = [e, runs.static[at] - runs.angle[at], before - runs.pressure[at]]
    if not N:
        zero = np.zeros_like(e)
        return np.stack(parts, axis=-1), (zero, zero)
    u = np.diff(np.vstack([runs.rest, runs.command]), axis=0) / dt  # row k: of the change at sample k
    back = np.arange(1, N + 1)
    index = at[:, None] + 1 - back
    late = np.where((index >= 0)[:, :, None], u[np.maximum(index, 0)], 0.0)
    late = late * float(growth_of(decay, dt)) ** -back[None, :, None]
    table = np.asarray(loop.window.table[:, :N], float)
    parts += [np.einsum("i,kil->kl", row, late) / N for row in table]
    squares = dt * late**2
    weighted = squares * ((N + 1 - back) * dt)[None, :, None]
    return np.stack(parts, axis=-1), (squares.sum(axis=1), weighted.sum(axis=1))
