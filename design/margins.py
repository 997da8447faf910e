"""Margins of the linear loop on every branch of the hysteresis and at both regulator rates.

The plant's frequency responses come from python-control, or, for a wrist with
effects, from `plants.linear.responses`, once per branch and rate; the loop of each
pair of gains is then a product, so that a whole map of gains costs little more
than one point.  Dead time of the plant is part of its response.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.pi import PI
from plants.linear import BRANCHES, RATES, branch_ss, responses
from plants.wrist import SAMPLE_TIME, Wrist

Array = NDArray[np.float64]


@dataclass(frozen=True)
class BranchResponse:
    """Frequency response of one branch at one rate: omega [rad/s], response [deg/V], both (n,);
    a (2, 2) and b (2,) are its state matrices, from command [V] to pressure and angle, None for a
    wrist with effects."""

    branch: str
    rate: str
    omega: Array
    response: NDArray[np.complex128]
    a: Array | None = None
    b: Array | None = None


@dataclass(frozen=True)
class Margins:
    """Margins of loops with one or many PIs, each field of the shape of the gains.

    Ms: largest magnitude of the sensitivity, infinite for an unstable loop.
    delay_margin_s: smallest extra dead time that makes the loop unstable; zero
    for an unstable loop, infinite where the loop gain never crosses one.
    Ms_at, delay_at: index into ``branch_responses`` of the branch that decides.
    """

    Ms: Array
    delay_margin_s: Array
    Ms_at: NDArray[np.intp]
    delay_at: NDArray[np.intp]


def branch_responses(wrist: Wrist, points: int = 800) -> list[BranchResponse]:
    """Frequency responses on {transit, line1, line2} x {slow, fast}, up to the Nyquist frequency.

    Effects that change slopes or rates add to that list, see `plants.linear.responses`.
    """
    import control

    omega = _frequencies(points)
    if wrist.effects:
        return [BranchResponse(r.branch, r.rate, omega, r.response) for r in responses(wrist, omega)]
    found = []
    for branch in BRANCHES:
        for rate in RATES:
            system = branch_ss(wrist, branch, rate)
            response = control.frequency_response(system, omega).complex
            plain = np.array(np.ravel(response))  # python-control's own array type is slow to index
            found.append(BranchResponse(branch, rate, omega, plain, system.A, system.B[:, 0]))
    return found


def margins(branches: list[BranchResponse], controller: PI) -> Margins:
    """Margins of a PI whose gains are floats or arrays, the worst over the branches given."""
    Kp, Ki = (np.ravel(np.asarray(k, float)) for k in np.broadcast_arrays(controller.Kp, controller.Ki))
    sensitivity, delay = np.empty((len(branches), Kp.size)), np.empty((len(branches), Kp.size))
    stable = np.empty((len(branches), Kp.size), bool)
    for i, branch in enumerate(branches):
        z = np.exp(1j * branch.omega * SAMPLE_TIME)
        for piece in np.array_split(np.arange(Kp.size), -(-Kp.size // 256)):  # bounds the memory
            c = Kp[piece, None] + Ki[piece, None] * (SAMPLE_TIME / (z - 1.0))
            loop = c * (branch.response / controller.gain)
            sensitivity[i, piece] = 1.0 / _least(np.abs(1.0 + loop))
            delay[i, piece] = _delay_margin(branch.omega, loop)
            if branch.a is None:
                stable[i, piece] = winds_not(loop) & (Ki[piece] > 0.0)
        if branch.a is not None:
            stable[i] = _stable(branch, Kp / controller.gain, Ki / controller.gain)
    sensitivity[~stable], delay[~stable] = np.inf, 0.0
    shape = np.broadcast(controller.Kp, controller.Ki).shape
    return Margins(
        sensitivity.max(axis=0).reshape(shape),
        delay.min(axis=0).reshape(shape),
        sensitivity.argmax(axis=0).reshape(shape),
        delay.argmin(axis=0).reshape(shape),
    )


def _least(rows: Array) -> Array:
    """Least value of each row, by the parabola through the least sample and its neighbours."""
    at = np.clip(rows.argmin(axis=1), 1, rows.shape[1] - 2)
    before, here, after = (rows[np.arange(len(rows)), at + i] for i in (-1, 0, 1))
    bend = before - 2.0 * here + after
    found: Array = here - np.where(
        bend > 0.0, (after - before) ** 2 / (8.0 * np.where(bend > 0.0, bend, 1.0)), 0.0
    )
    least: Array = np.minimum(found, rows.min(axis=1))
    return least


def _delay_margin(omega: Array, loop: NDArray[np.complex128]) -> Array:
    """Least dead time [s] that turns the phase at a gain crossing to -180 degrees; one per row."""
    above = np.abs(loop) > 1.0
    rows, columns = np.nonzero(above[:, 1:] != above[:, :-1])
    before, after = loop[rows, columns], loop[rows, columns + 1]
    low, high = np.log(np.abs(before)), np.log(np.abs(after))
    share = low / (low - high)
    at = omega[columns] * (omega[columns + 1] / omega[columns]) ** share
    # Unit-size phasors, so that interpolating them interpolates the phase across -180 degrees.
    phase = np.angle((1.0 - share) * before / np.abs(before) + share * after / np.abs(after))
    found = np.full(len(loop), np.inf)
    np.minimum.at(found, rows, np.mod(phase + np.pi, 2.0 * np.pi) / at)
    return found


def _frequencies(points: int) -> Array:
    """Frequencies [rad/s] from far below any loop's to just below the Nyquist frequency, (points,)."""
    found: Array = np.geomspace(1e-2, 0.999 * np.pi / SAMPLE_TIME, points)
    return found


def winds_not(loop: NDArray[np.complex128]) -> NDArray[np.bool_]:
    """Whether closed loops are stable, by Nyquist's criterion, one per row of open loops.

    For open loops that are stable but for an integrator, at frequencies from far
    below the loop's to just below Nyquist's: the phase of 1 + L starts between
    -180 degrees and 0 and must end near 0 without a turn on the way.  Neighbouring
    points must lie less than half a turn apart as seen from -1.
    """
    turned = 1.0 + loop
    steps = np.angle(turned[:, 1:] / turned[:, :-1])
    stable: NDArray[np.bool_] = np.abs(np.angle(turned[:, 0]) + steps.sum(axis=1)) < 0.5 * np.pi
    return stable


def _stable(branch: BranchResponse, Kp: Array, Ki: Array) -> NDArray[np.bool_]:
    """Whether the poles of the sampled loop lie inside the unit circle; gains in V/deg."""
    assert branch.a is not None
    assert branch.b is not None
    closed = np.zeros((Kp.size, 3, 3))
    closed[:, :2, :2] = branch.a
    closed[:, :2, 1] -= branch.b * Kp[:, None]
    closed[:, :2, 2] = branch.b
    closed[:, 2, 1] = -Ki * SAMPLE_TIME
    closed[:, 2, 2] = 1.0
    poles = np.linalg.eigvals(closed)
    inside: NDArray[np.bool_] = np.abs(poles).max(axis=1) < 1.0 - 1e-9
    return inside


def loop_tf(wrist: Wrist, controller: PI, branch: str, rate: str) -> Any:
    """Open loop of PI and wrist on one branch as a discrete python-control system."""
    import control

    integrator = control.tf([SAMPLE_TIME], [1.0, -1.0], SAMPLE_TIME)
    c = (controller.Kp + controller.Ki * integrator) / controller.gain
    return control.ss(c) * branch_ss(wrist, branch, rate)


def by_python_control(wrist: Wrist, controller: PI) -> list[dict[str, Any]]:
    """Margins on every branch and rate, computed by python-control alone, for one pair of gains.

    Each row: branch, rate, gain_margin, phase_margin_deg, delay_margin_s, Ms, stable.
    Of a wrist with effects python-control gets the frequency response of the open
    loop and no poles; stability is then Nyquist's criterion.
    """
    import control

    omega = _frequencies(1500)
    if wrist.effects:
        z = np.exp(1j * omega * SAMPLE_TIME)
        c = (controller.Kp + controller.Ki * (SAMPLE_TIME / (z - 1.0))) / controller.gain
        of = [(r.branch, r.rate, c * r.response) for r in responses(wrist, omega)]
        return [_row(*o, omega, bool(winds_not(o[2][None])[0]) and controller.Ki > 0.0) for o in of]
    rows = []
    for branch in BRANCHES:
        for rate in RATES:
            loop = loop_tf(wrist, controller, branch, rate)
            poles = control.feedback(loop, 1).poles()
            stable = bool(np.abs(poles).max() < 1.0 - 1e-9)
            response = control.frequency_response(loop, omega).complex
            rows.append(_row(branch, rate, response, omega, stable))
    return rows


def _row(branch: str, rate: str, response: Any, omega: Array, stable: bool) -> dict[str, Any]:
    """Margins of one open loop from its frequency response, by python-control."""
    import control

    size = np.abs(1.0 + response)
    # From the response, since polynomials in z lose digits at 1 ms.
    gm, pm, _, _, wc, _ = control.stability_margins(control.frd(response, omega, smooth=True), returnall=True)
    delays = np.mod(np.radians(pm), 2 * np.pi) / wc if len(wc) else np.array([np.inf])
    above = [g for g in gm if g > 1.0]
    return {
        "branch": branch, "rate": rate, "stable": stable,
        "gain_margin": float(min(above, default=np.inf)),
        "phase_margin_deg": float(min(pm, default=np.inf)),
        "delay_margin_s": float(delays.min()) if stable else 0.0,
        "Ms": float(1.0 / size.min()) if stable else float("inf"),
    }  # fmt: skip
