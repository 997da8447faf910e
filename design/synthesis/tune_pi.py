"""A PI for plants of python-control: one pair of gains for a list of them, with margins on each.

Among the gains that hold the limits on every plant, those with the largest integral gain: its reciprocal is
the integrated error after a step of load, and maximising it under a bound on the sensitivity is the design
of Astrom, Panagopoulos & Hagglund, Automatica 34 (1998) 585, doi 10.1016/S0005-1098(98)00011-9, for
several plants at once.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.margins import gain_crossings
from plants.errors import InputError

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

POINTS = 1500
"""Frequencies of each plant."""

DECADES, GRID, ZOOMS = 4.0, 41, 6
"""Decades of either gain that are searched at first, values of each, and how often the search closes in."""


@dataclass(frozen=True)
class MarginLimits:
    """Limits on the margins of every loop: largest sensitivity Ms and complementary sensitivity Mt, least
    gain
    margin [1], phase margin [deg] and delay margin [s].

    Raises ValueError for limits that no loop can hold.
    """

    Ms: float = 1.7
    Mt: float = float("inf")
    gain_margin: float = 1.0
    phase_margin_deg: float = 0.0
    delay_margin_s: float = 0.0

    def __post_init__(self) -> None:
        if not (self.Ms > 1.0 and self.Mt >= 1.0):
            raise ValueError("Ms must be above 1 and Mt at least 1: no loop with an integrator is below")


@dataclass(frozen=True)
class LoopMargins:
    """Margins of one loop: peaks of the sensitivity and of the complementary sensitivity, gain margin
    [1], phase margin [deg] and delay margin [s], infinite where the loop has none; stable: whether the closed
    loop is."""

    Ms: float
    Mt: float
    gain_margin: float
    phase_margin_deg: float
    delay_margin_s: float
    stable: bool


@dataclass(frozen=True)
class TunedPI:
    """Gains of Kp + Ki/s, of plants in discrete time Kp + Ki dt/(z - 1), and what they hold on each plant."""

    Kp: float
    Ki: float
    margins: tuple[LoopMargins, ...]


@dataclass(frozen=True)
class _Plant:
    """State matrices, frequencies [rad/s], s or z there, response with the dead time, integrator, dt [s] (0
    for continuous time) and dead time [s]."""

    a: Array
    b: Array
    c: Array
    d: float
    omega: Array
    response: Complex
    integrator: Complex
    dt: float
    dead_time: float


def tune_pi(
    systems: Sequence[Any],
    limits: MarginLimits | None = None,
    dead_times: float | Sequence[float] = 0.0,
) -> TunedPI:
    """The PI with the largest integral gain that meets limits on each of several plants.

    systems: single-input single-output systems of python-control, continuous or discrete, such as the
    branches of a hysteresis or operating points; dead_times [s]: of all, or of each, beside their own.
    Raises InputError for a list that is empty, systems that are none of these or whose gains differ in sign,
    and where no gains hold the limits.

    >>> import control
    >>> slow, fast = control.tf(2.0, [1.0, 1.0]), control.tf(1.0, [0.5, 1.0])
    >>> found = tune_pi([slow, fast], MarginLimits(Ms=1.5), dead_times=0.1)
    >>> max(m.Ms for m in found.margins) <= 1.5, all(m.stable for m in found.margins)
    (True, True)
    """
    if not len(systems):
        raise InputError("systems: none given; give a list of systems of python-control")
    limits = limits or MarginLimits()
    late = np.broadcast_to(np.asarray(dead_times, float), (len(systems),))
    plants = [_plant(s, float(t), i) for i, (s, t) in enumerate(zip(systems, late, strict=True))]
    signs = {float(np.sign(p.response[0].real)) for p in plants}
    if len(signs) > 1:
        raise InputError("systems: their gains differ in sign; no PI closes a loop around both kinds")
    sign = signs.pop() or 1.0
    Kp, Ki = _searched(plants, limits, sign)
    return TunedPI(Kp, Ki, tuple(_margins(p, Kp, Ki) for p in plants))


def margins_of(system: Any, Kp: float, Ki: float, dead_time: float = 0.0) -> LoopMargins:
    """Margins of the loop of a PI around a system of python-control, `dead_time` [s] beside its own.

    Raises InputError for a system that is none of `tune_pi`.
    """
    return _margins(_plant(system, dead_time, 0), Kp, Ki)


def _plant(system: Any, dead_time: float, place: int) -> _Plant:
    import control

    where = f"systems[{place}]"
    if not isinstance(system, control.TransferFunction | control.StateSpace):
        raise InputError(f"{where}: is no transfer function or state space of python-control")
    if not system.issiso():
        raise InputError(f"{where}: has several inputs or outputs; give single-input single-output systems")
    if not (np.isfinite(dead_time) and dead_time >= 0.0):
        raise InputError(f"{where}: dead time {dead_time:g} s is none")
    dt = float(system.dt) if system.isdtime(strict=True) else 0.0
    states = control.ss(system)
    omega = _frequencies(system, dt, dead_time)
    point = np.exp(1j * omega * dt) if dt else 1j * omega
    integrator = np.asarray(dt / (point - 1.0) if dt else 1.0 / point, complex)
    response = np.asarray(system(point), complex).ravel() * np.exp(-1j * omega * dead_time)
    return _Plant(
        np.asarray(states.A, float), np.asarray(states.B, float)[:, 0], np.asarray(states.C, float)[0],
        float(np.ravel(states.D)[0]), omega, response, integrator, dt,
        dead_time,
    )  # fmt: skip


def _frequencies(system: Any, dt: float, dead_time: float) -> Array:
    """Frequencies [rad/s] around all that a system does, denser at its resonances."""
    marks = np.concatenate([np.ravel(system.poles()), np.ravel(system.zeros())]).astype(complex)
    if dt:
        marks = np.log(marks[np.abs(marks) > 1e-9]) / dt
    marks = marks[np.abs(marks) > 1e-9]
    known = np.abs(marks) if len(marks) else np.array([1.0])
    low, high = 1e-3 * known.min(), 1e3 * known.max()
    if dead_time:
        high = max(high, 30.0 / dead_time)
    if dt:
        high = 0.9999 * np.pi / dt
        low = min(low, 1e-4 * high)
    near = [abs(p) + abs(p.real) * np.linspace(-4.0, 4.0, 41) for p in marks if abs(p.real) < 0.3 * abs(p)]
    grid = np.concatenate([np.geomspace(low, high, POINTS), *near])
    return np.unique(grid[(grid >= low) & (grid <= high)])


def _searched(plants: Sequence[_Plant], limits: MarginLimits, sign: float) -> tuple[float, float]:
    """Gains with the largest integral gain that hold the limits, by grids that close in on it."""
    steady = max(float(np.median(np.abs(p.response[:50]))) for p in plants)
    # The integral gain at which the slowest plant would cross gain one where its phase begins to fall.
    turned = [np.argmax(np.abs(np.angle(p.response / p.response[0])) > 0.5) for p in plants]
    corner = min(float(p.omega[t]) for p, t in zip(plants, turned, strict=True))
    centre = np.log10(1.0 / steady), np.log10(max(corner, plants[0].omega[0]) / steady)
    width = DECADES
    best: tuple[float, float] | None = None
    for zoom in range(ZOOMS):
        Kp = np.logspace(centre[0] - width / 2, centre[0] + width / 2, GRID)
        Ki = np.logspace(centre[1] - width / 2, centre[1] + width / 2, GRID)
        if zoom == 0:
            Kp = np.append(0.0, Kp)
        grid = [g.ravel() for g in np.meshgrid(sign * Kp, sign * Ki, indexing="ij")]
        good = np.all([_hold(p, grid[0], grid[1], limits) for p in plants], axis=0)
        if good.any():
            at = int(np.argmax(np.where(good, np.abs(grid[1]), -1.0)))
            if best is None or abs(grid[1][at]) >= abs(best[1]):
                best = float(grid[0][at]), float(grid[1][at])
        elif best is None and zoom == 0:
            width *= 2.0  # further out, and finer below
            continue
        if best is None:
            break
        centre = np.log10(max(abs(best[0]), 1e-12)), np.log10(abs(best[1]))
        width /= 5.0
    if best is None:
        raise InputError("limits: no gains hold them on every system; ask for less, or give fewer systems")
    return best


def _hold(plant: _Plant, Kp: Array, Ki: Array, limits: MarginLimits) -> NDArray[np.bool_]:
    """Which pairs of gains, (n,), hold the limits on a plant."""
    good = np.empty(len(Kp), bool)
    for piece in np.array_split(np.arange(len(Kp)), -(-len(Kp) // 256)):
        loop = (Kp[piece, None] + Ki[piece, None] * plant.integrator) * plant.response
        turned = np.abs(1.0 + loop)
        held = (
            (turned.min(axis=1) >= 1.0 / limits.Ms)
            & ((np.abs(loop) / turned).max(axis=1) <= limits.Mt)
            & (np.abs(loop[:, 0]) > 1.0)  # a crossing below all frequencies would be seen by no margin
        )
        for i in np.flatnonzero(held):
            m = _crossings(plant, loop[i])
            held[i] = (
                m[0] >= limits.gain_margin
                and m[1] >= limits.phase_margin_deg
                and m[2] > limits.delay_margin_s
                and _stable(plant, float(Kp[piece[i]]), float(Ki[piece[i]]))
            )
        good[piece] = held
    return good


def _margins(plant: _Plant, Kp: float, Ki: float) -> LoopMargins:
    loop = (Kp + Ki * plant.integrator) * plant.response
    turned = np.abs(1.0 + loop)
    gain, phase, delay = _crossings(plant, loop)
    stable = _stable(plant, Kp, Ki)
    return LoopMargins(
        float(1.0 / turned.min()), float((np.abs(loop) / turned).max()), gain, phase, delay, stable
    )


def _crossings(plant: _Plant, loop: Complex) -> tuple[float, float, float]:
    """Gain margin upwards [1], phase margin [deg] and delay margin [s] of a loop, by lines between points."""
    _, at, lag = gain_crossings(plant.omega, loop[None])
    j = np.flatnonzero((loop.imag[:-1] >= 0.0) != (loop.imag[1:] >= 0.0))
    share = loop.imag[j] / (loop.imag[j] - loop.imag[j + 1])
    real = loop.real[j] + share * (loop.real[j + 1] - loop.real[j])
    above = real[(real < 0.0) & (real > -1.0)]
    gain = float((-1.0 / above).min()) if len(above) else np.inf
    degrees = float(np.degrees(np.minimum(lag, 2.0 * np.pi - lag)).min()) if len(at) else np.inf
    return gain, degrees, float((lag / at).min()) if len(at) else np.inf


def _stable(plant: _Plant, Kp: float, Ki: float) -> bool:
    """Whether the closed loop is stable: its poles without dead time, and then no crossing before it."""
    held = 1.0 / (1.0 + plant.d * Kp)  # of y = c x + d u, u = Ki q - Kp y
    y_x, y_q = held * plant.c, held * plant.d * Ki
    u_x, u_q = -Kp * y_x, Ki - Kp * y_q
    n = len(plant.b)
    closed = np.zeros((n + 1, n + 1))
    closed[:n, :n] = plant.a + np.outer(plant.b, u_x)
    closed[:n, n] = plant.b * u_q
    closed[n, :n], closed[n, n] = -y_x, -y_q
    if plant.dt:
        closed[n] *= plant.dt
        closed[n, n] += 1.0
    poles = np.linalg.eigvals(closed)
    inside = np.abs(poles) < 1.0 if plant.dt else poles.real < 0.0
    if not inside.all():
        return False
    if not plant.dead_time:
        return True
    bare = (Kp + Ki * plant.integrator) * plant.response * np.exp(1j * plant.omega * plant.dead_time)
    return _crossings(plant, bare)[2] > plant.dead_time
