"""Open loops of PI and wrist on every branch at every rate, and their margins by python-control.

Slower than `design.margins`, for one pair of gains, and with all that python-control tells of a loop.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.controllers.pi import PI
from design.margins import frequencies, least_of_rows, winds_not
from plants.linearisation import RATES, branch_slopes, branch_ss, frequency_response, responses
from plants.parameters.remainder import UncertaintyWeight
from plants.wrist import Wrist

Array = NDArray[np.float64]


def loop_tf(wrist: Wrist, controller: PI, branch: str, rate: str) -> Any:
    """Open loop of PI and wrist on one branch as a discrete python-control system."""
    import control

    dt = wrist.rig.sample_time
    c = controller.transfer(control.tf([1.0, 0.0], [1.0], dt), dt)
    return control.ss(c) * branch_ss(wrist, branch, rate)


@dataclass(frozen=True)
class OpenLoopTransfer:
    """Open loop of PI and wrist on one branch at one rate: `at` gives its frequency response, shape of
    omega [rad/s]; stable: whether it is so when closed, None where it has no poles to tell."""

    branch: str
    rate: str
    at: Callable[[Array], NDArray[np.complex128]]
    stable: bool | None = None


def open_loops(
    wrist: Wrist, controller: PI, dead_time: float = 0.0, rates: tuple[str, ...] = RATES
) -> list[OpenLoopTransfer]:
    """Open loops on every branch at some rates, behind a further dead time [s], for one pair of gains.

    The plant's responses are python-control's, or, for a wrist with effects, those of
    `plants.linearisation.responses`.
    """
    import control

    dt = wrist.rig.sample_time

    def known(omega: Array) -> NDArray[np.complex128]:
        z = np.exp(1j * omega * dt)
        return np.asarray(controller.transfer(z, dt) * np.exp(-1j * omega * dead_time), complex)

    if wrist.effects:
        names = [(r.branch, r.rate) for r in responses(wrist, np.array([1.0]))]
        return [
            OpenLoopTransfer(*n, lambda omega, i=i: known(omega) * responses(wrist, omega)[i].response)  # type: ignore[misc]
            for i, n in enumerate(names)
            if n[1].startswith(rates)
        ]
    found = []
    for branch in branch_slopes(wrist):
        for rate in rates:
            loop = loop_tf(wrist, controller, branch, rate)
            poles = control.feedback(loop, 1).poles()
            stable = bool(np.abs(poles).max() < 1.0 - 1e-9) if dead_time == 0.0 else None

            def at(omega: Array, loop: Any = loop) -> NDArray[np.complex128]:
                plain = frequency_response(loop.A, loop.B, loop.C, loop.D, omega, dt)[0]
                return np.asarray(plain * np.exp(-1j * omega * dead_time), complex)

            found.append(OpenLoopTransfer(branch, rate, at, stable))
    return found


def by_python_control(
    wrist: Wrist,
    controller: PI,
    dead_time: float = 0.0,
    rates: tuple[str, ...] = RATES,
    weight: UncertaintyWeight | None = None,
) -> list[dict[str, Any]]:
    """Margins on every branch at every rate, computed by python-control alone, for one pair of gains.

    Each row: branch, rate, gain_margin, phase_margin_deg, delay_margin_s, Ms, Mt, disk_margin, stable;
    dead_time [s]: further than that of the wrist, stands in the loop.  Mt is the peak of the
    complementary sensitivity T, disk_margin that of zero skew, the least |2 (1 + L) / (1 - L)| (Seiler,
    Packard & Gahinet, An introduction to disk margins, 2020, doi 10.1109/MCS.2020.3005277); for an
    unstable loop Ms and Mt are infinite, the disk and delay margins zero.  Of a wrist with effects, or
    behind a dead time, python-control gets the frequency response of the open loop and no poles;
    stability is then Nyquist's criterion.  With the weight of unmodelled dynamics rows have WT too, the
    peak of |W T|.
    """
    omega = frequencies(1500, wrist.rig.sample_time)
    return [
        _row(loop, omega, controller.Ki > 0.0, weight)
        for loop in open_loops(wrist, controller, dead_time, rates)
    ]


def _row(
    loop: OpenLoopTransfer, omega: Array, integrates: bool, weight: UncertaintyWeight | None = None
) -> dict[str, Any]:
    """Margins of one open loop from its frequency response, by python-control."""
    import control

    response = loop.at(omega)
    stable = bool(winds_not(response[None])[0]) and integrates if loop.stable is None else loop.stable
    # From the response, since polynomials in z lose digits at 1 ms.
    found = [
        control.stability_margins(control.frd(response[i], omega[i], smooth=True), returnall=True)
        for i in _crossings(response)
    ]
    gm, pm, wc = (np.concatenate([[], *(m[k] for m in found)]) for k in (0, 1, 4))
    delays = np.mod(np.radians(pm), 2 * np.pi) / wc if len(wc) else np.array([np.inf])
    above = [g for g in gm if g > 1.0]
    Mt = 1.0 / least_over(loop.at, _by_complement, omega, response) if stable else float("inf")
    if integrates:
        Mt = max(1.0, Mt)  # T is 1 at zero frequency, below the grid
    more = {}
    if weight is not None:
        size = np.abs(weight.response(omega))
        WT = float(1.0 / np.min(_by_complement(response) / size)) if stable else float("inf")
        more["WT"] = max(WT, weight.low)
    return more | {
        "branch": loop.branch, "rate": loop.rate, "stable": stable,
        "gain_margin": float(min(above, default=np.inf)),
        "phase_margin_deg": float(min(pm, default=np.inf)),
        "delay_margin_s": float(delays.min()) if stable else 0.0,
        "Ms": 1.0 / least_over(loop.at, _by_sensitivity, omega, response) if stable else float("inf"),
        "Mt": Mt,
        "disk_margin": least_over(loop.at, _by_disk, omega, response) if stable else 0.0,
    }  # fmt: skip


def _crossings(response: NDArray[np.complex128], beside: int = 24) -> list[NDArray[np.intp]]:
    """Pieces of the grid around the places where the gain crosses one or the phase -180 degrees.

    python-control evaluates its spline one frequency at a time.  A spline forgets what lies so many points
    away: each point nearer to a piece's end counts a quarter of the one before.
    """
    gain, phase = (np.diff(np.sign(x)) != 0.0 for x in (np.abs(response) - 1.0, np.angle(-response)))
    at = np.flatnonzero(gain | (phase & (response.real[:-1] <= 0.0)))
    near = np.unique(np.clip(at[:, None] + np.arange(-beside, beside + 2), 0, response.size - 1))
    return [piece for piece in np.split(near, 1 + np.flatnonzero(np.diff(near) > 1)) if piece.size]


def _by_sensitivity(loop: NDArray[np.complex128]) -> Array:
    return np.asarray(np.abs(1.0 + loop), float)


def _by_complement(loop: NDArray[np.complex128]) -> Array:
    return np.asarray(np.abs(1.0 + loop) / np.maximum(np.abs(loop), 1e-300), float)


def _by_disk(loop: NDArray[np.complex128]) -> Array:
    return np.asarray(2.0 * np.abs(1.0 + loop) / np.maximum(np.abs(1.0 - loop), 1e-300), float)


def least_over(
    at: Callable[[Array], NDArray[np.complex128]],
    size: Callable[[NDArray[np.complex128]], Array],
    omega: Array,
    response: NDArray[np.complex128],
) -> float:
    """Least size of a response over all frequencies, good to about 1e-6 of itself where the grid
    `omega` [rad/s], on which it is known, resolves its valleys: each that may be the deepest is looked
    at 40 times closer."""
    on_grid = size(response)
    inner = on_grid[1:-1]
    valleys = 1 + np.flatnonzero((inner <= on_grid[:-2]) & (inner <= on_grid[2:]))
    least = float(on_grid.min())
    deep = [i for i in valleys if on_grid[i] < 1.1 * least]
    if not deep:
        return least
    near = np.array([np.geomspace(omega[i - 1], omega[i + 1], 81) for i in deep])
    closer = size(at(near.ravel())).reshape(near.shape)
    return min(least, float(least_of_rows(closer).min()))
