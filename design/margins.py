"""Margins of the linear loop on every branch of the hysteresis and at both regulator rates.

The plant's frequency responses are those of its state matrices, or, for a wrist with
effects, from `plants.linearisation.responses`, once per branch and rate; the loop of each
pair of gains is then a product, so that a whole map of gains costs little more
than one point.  Dead time of the plant is part of its response.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from design.controllers.pi import PI
from plants.kernel import pytrees
from plants.linearisation import RATES, branch_matrices, branch_slopes, frequency_response, responses
from plants.parameters.remainder import UncertaintyWeight
from plants.wrist import SAMPLE_TIME, Wrist

Array = NDArray[np.float64]

ROWS = 256
"""Loops that are looked at together: that bounds the memory."""

LINEAR = ("Ms", "Mt", "delay_margin_s", "WT")
"""Limits that belong to the linear loop, on branches; the others to runs."""


@dataclass(frozen=True)
class BranchResponse:
    """Frequency response of one branch at one rate: omega [rad/s], response of the angle [deg/V] and of the
    pressure [kPa/V], (n,) each;
    a (2, 2) and b (2,) are its state matrices, from command [V] to pressure and angle, None for a
    wrist with effects; dt: sample time [s]; weight: |W| of unmodelled dynamics at omega, None without."""

    branch: str
    rate: str
    omega: Array
    response: NDArray[np.complex128]
    pressure: NDArray[np.complex128]
    a: Array | None = None
    b: Array | None = None
    dt: float = SAMPLE_TIME
    weight: Array | None = None


@dataclass(frozen=True)
class Margins:
    """Margins of loops with one or many PIs, each field of the shape of the gains.

    Ms, Mt: largest magnitude of the sensitivity and of the complementary sensitivity, infinite for an
    unstable loop.
    delay_margin_s: smallest extra dead time that makes the loop unstable; zero
    for an unstable loop, infinite where the loop gain never crosses one.
    WT: largest |W T| of branches that have unmodelled dynamics of weight W; these make no loop unstable where
    it is below 1; None without (Skogestad, Postlethwaite, Multivariable Feedback Control, 2005, section 7.5).
    Ms_at, delay_at, Mt_at, WT_at: index into ``branch_responses`` of the branch that decides.
    """

    Ms: Array
    delay_margin_s: Array
    Ms_at: NDArray[np.intp]
    delay_at: NDArray[np.intp]
    Mt: Array
    Mt_at: NDArray[np.intp]
    WT: Array | None = None
    WT_at: NDArray[np.intp] | None = None

    @property
    def values(self) -> dict[str, Array]:
        """The margins by the names of their limits."""
        found = zip(LINEAR, (self.Ms, self.Mt, self.delay_margin_s, self.WT), strict=True)
        return {n: v for n, v in found if v is not None}

    @property
    def at(self) -> dict[str, NDArray[np.intp]]:
        """The branches that decide, by the names of the limits."""
        found = zip(LINEAR, (self.Ms_at, self.Mt_at, self.delay_at, self.WT_at), strict=True)
        return {n: v for n, v in found if v is not None}


class FeedbackLaw(Protocol):
    """A controller whose loop is closed by a PI of the angle, and by what else it measures."""

    @property
    def Kp(self) -> Any:
        """Proportional gain [kPa/deg], a float or an array."""
        ...

    @property
    def Ki(self) -> Any:
        """Integral gain [kPa/(deg s)], likewise."""
        ...

    def open_loop(self, angle: Any, pressure: Any, z: Any, dt: float = SAMPLE_TIME) -> Any:
        """The loop, broken at the command, from the responses of angle [deg/V] and pressure [kPa/V] to the
        command at points z, for a sample time [s]."""
        ...


def branch_responses(wrist: Wrist, points: int = 800) -> list[BranchResponse]:
    """Frequency responses on every branch of the hysteresis at both rates, up to the Nyquist frequency.

    Effects that change slopes or rates add to that list, see `plants.linearisation.responses`.
    """
    dt = wrist.rig.sample_time
    omega = frequencies(points, dt)
    if wrist.effects:
        return [
            BranchResponse(r.branch, r.rate, omega, r.response, r.pressure, dt=dt)
            for r in responses(wrist, omega)
        ]
    found = []
    for branch in branch_slopes(wrist):
        for rate in RATES:
            a, b = branch_matrices(wrist, branch, rate)
            pressure, angle = frequency_response(a, b, np.eye(2), np.zeros((2, 1)), omega, dt)
            found.append(BranchResponse(branch, rate, omega, angle, pressure, a, b[:, 0], dt))
    return found


def margins(branches: Sequence[BranchResponse], controller: FeedbackLaw) -> Margins:
    """Margins of a PI, or of another law whose only integrator is that of Ki, settings floats or arrays; the
    worst over the branches given."""
    settings = np.broadcast_arrays(*(np.asarray(v, float) for v in pytrees.leaves(controller)))
    shape = settings[0].shape
    Kp, Ki = (np.broadcast_to(k, shape).ravel() for k in (controller.Kp, controller.Ki))
    # The poles of a plain PI's loop are at hand; of others Nyquist's criterion tells.
    plain = controller if isinstance(controller, PI) and not np.any(getattr(controller, "Tf", 0.0)) else None
    sensitivity, complement, delay = np.empty((3, len(branches), Kp.size))
    uncertain = np.zeros((len(branches), Kp.size))
    weighed = np.array([b.weight is not None for b in branches])
    stable = np.empty((len(branches), Kp.size), bool)
    for some in _alike(branches):
        first = branches[some[0]]
        omega, z = first.omega, np.exp(1j * first.omega * first.dt)
        for piece in np.array_split(np.arange(Kp.size), -(-Kp.size // ROWS)):
            law, together = _piece(controller, shape, piece), max(1, ROWS // piece.size)
            for part in np.array_split(some, -(-some.size // together)):
                at, of = np.ix_(part, piece), [branches[i] for i in part]
                angle, pressure = (
                    np.array(r)[:, None] for r in ([b.response for b in of], [b.pressure for b in of])
                )
                loop = law.open_loop(angle, pressure, z, first.dt).reshape(-1, omega.size)
                turned, size = np.abs(1.0 + loop), (part.size, piece.size)
                sensitivity[at] = (1.0 / least_of_rows(turned)).reshape(size)
                relative = turned / np.maximum(np.abs(loop), 1e-300)
                complement[at] = (1.0 / least_of_rows(relative)).reshape(size)
                if weighed[part].any():
                    weights = np.array([np.ones(omega.size) if b.weight is None else b.weight for b in of])
                    away = relative.reshape(*size, -1) / np.maximum(weights, 1e-9)[:, None]
                    uncertain[at] = (1.0 / least_of_rows(away.reshape(-1, omega.size))).reshape(size)
                delay[at] = delay_margins(omega, loop).reshape(size)
                if first.a is None or plain is None:
                    stable[at] = winds_not(loop).reshape(size) & (Ki[piece] > 0.0)
                else:
                    stable[at] = _stable(of, Kp[piece] / plain.gain, Ki[piece] / plain.gain)
    complement = np.where(Ki > 0.0, np.maximum(complement, 1.0), complement)  # T is 1 at zero frequency
    sensitivity[~stable], complement[~stable], delay[~stable] = np.inf, np.inf, 0.0
    uncertain[~stable], uncertain[~weighed] = np.inf, 0.0
    return Margins(
        sensitivity.max(axis=0).reshape(shape),
        delay.min(axis=0).reshape(shape),
        sensitivity.argmax(axis=0).reshape(shape),
        delay.argmin(axis=0).reshape(shape),
        complement.max(axis=0).reshape(shape),
        complement.argmax(axis=0).reshape(shape),
        *((f(uncertain, axis=0).reshape(shape) for f in (np.max, np.argmax)) if weighed.any() else ()),
    )


def with_dynamics(
    branches: Sequence[BranchResponse], weight: UncertaintyWeight | None
) -> list[BranchResponse]:
    """Branches with unmodelled dynamics of a weight, or without."""
    if weight is None:
        return list(branches)
    return [replace(b, weight=np.abs(weight.response(b.omega))) for b in branches]


def _alike(branches: Sequence[BranchResponse]) -> list[NDArray[np.intp]]:
    """Places of branches whose responses are at the same frequencies and that have, or have not, matrices."""
    found: dict[tuple[Any, ...], list[int]] = {}
    for i, b in enumerate(branches):
        found.setdefault((b.dt, b.a is None, b.omega.tobytes()), []).append(i)
    return [np.array(places) for places in found.values()]


def _piece(controller: FeedbackLaw, shape: tuple[int, ...], piece: NDArray[np.intp]) -> FeedbackLaw:
    """Some of the controllers, in columns."""
    columns = [np.ravel(np.broadcast_to(v, shape))[piece, None] for v in pytrees.leaves(controller)]
    return cast(FeedbackLaw, pytrees.like(controller, columns))


def least_of_rows(rows: Array) -> Array:
    """Least value of each row, by the parabola through the least sample and its neighbours."""
    at = np.clip(rows.argmin(axis=1), 1, rows.shape[1] - 2)
    before, here, after = (rows[np.arange(len(rows)), at + i] for i in (-1, 0, 1))
    bend = before - 2.0 * here + after
    found: Array = here - np.where(
        bend > 0.0, (after - before) ** 2 / (8.0 * np.where(bend > 0.0, bend, 1.0)), 0.0
    )
    least: Array = np.minimum(found, rows.min(axis=1))
    return least


def gain_crossings(omega: Array, loop: NDArray[np.complex128]) -> tuple[NDArray[np.intp], Array, Array]:
    """Where the gain of open loops, one per row, crosses one: row, frequency [rad/s] and how far the phase
    lies beyond -180 degrees [rad], from 0 to a turn; one entry per crossing."""
    above = np.abs(loop) > 1.0
    rows, columns = np.nonzero(above[:, 1:] != above[:, :-1])
    before, after = loop[rows, columns], loop[rows, columns + 1]
    low, high = np.log(np.abs(before)), np.log(np.abs(after))
    share = low / (low - high)
    at = omega[columns] * (omega[columns + 1] / omega[columns]) ** share
    # Unit-size phasors, so that interpolating them interpolates the phase across -180 degrees.
    phase = np.angle((1.0 - share) * before / np.abs(before) + share * after / np.abs(after))
    return rows, at, np.mod(phase + np.pi, 2.0 * np.pi)


def delay_margins(omega: Array, loop: NDArray[np.complex128]) -> Array:
    """Least dead time [s] that turns the phase at a gain crossing to -180 degrees; one per row."""
    rows, at, beyond = gain_crossings(omega, loop)
    found = np.full(len(loop), np.inf)
    np.minimum.at(found, rows, beyond / at)
    return found


def frequencies(points: int, dt: float) -> Array:
    """Frequencies [rad/s] from far below any loop's to just below the Nyquist frequency, (points,)."""
    found: Array = np.geomspace(1e-2, 0.999 * np.pi / dt, points)
    return found


def winds_not(loop: NDArray[np.complex128]) -> NDArray[np.bool_]:
    """Whether closed loops are stable, by Nyquist's criterion, one per row of open loops.

    For open loops that are stable but for an integrator, at frequencies from far
    below the loop's to just below Nyquist's: the phase of 1 + L starts between
    -180 degrees and 0 and must end near 0 without a turn on the way.  Neighbouring
    points must lie less than half a turn apart as seen from -1.  A plant of negative gain,
    with which an integrator runs off, is not told: the least slope of a learnt block is a bound
    that may lie below zero where no slope does.
    """
    turned = 1.0 + loop
    steps = np.angle(turned[:, 1:] / turned[:, :-1])
    stable: NDArray[np.bool_] = np.abs(np.angle(turned[:, 0]) + steps.sum(axis=1)) < 0.5 * np.pi
    return stable


def _stable(branches: Sequence[BranchResponse], Kp: Array, Ki: Array) -> NDArray[np.bool_]:
    """Whether the poles of the sampled loop lie inside the unit circle, (branches, gains); gains in V/deg."""
    a, b = np.array([r.a for r in branches])[:, None], np.array([r.b for r in branches])[:, None]
    closed = np.zeros((len(branches), Kp.size, 3, 3))
    closed[..., :2, :2] = a
    closed[..., :2, 1] -= b * Kp[:, None]
    closed[..., :2, 2] = b
    closed[..., 2, 1] = -Ki * branches[0].dt
    closed[..., 2, 2] = 1.0
    poles = np.linalg.eigvals(closed)
    inside: NDArray[np.bool_] = np.abs(poles).max(axis=-1) < 1.0 - 1e-9
    return inside
