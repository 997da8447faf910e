"""Margins of the linear loop on every branch of the hysteresis and at both regulator rates.

The plant's frequency responses come from python-control, once per branch and
rate; the loop of each pair of gains is then a product, so that a whole map of
gains costs little more than one point.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.pi import PI
from plants.linear import BRANCHES, RATES, branch_ss
from plants.wrist import SAMPLE_TIME, Wrist

Array = NDArray[np.float64]


@dataclass(frozen=True)
class BranchResponse:
    """Frequency response of one branch at one rate: omega [rad/s], response [deg/V], both (n,);
    a (2, 2) and b (2,) are its state matrices, from command [V] to pressure and angle."""

    branch: str
    rate: str
    omega: Array
    response: NDArray[np.complex128]
    a: Array
    b: Array


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
    """Frequency responses on {transit, line1, line2} x {slow, fast}, up to the Nyquist frequency."""
    import control

    omega = np.geomspace(1e-2, 0.999 * np.pi / SAMPLE_TIME, points)
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
    for i, branch in enumerate(branches):
        z = np.exp(1j * branch.omega * SAMPLE_TIME)
        for piece in np.array_split(np.arange(Kp.size), -(-Kp.size // 256)):  # bounds the memory
            c = Kp[piece, None] + Ki[piece, None] * (SAMPLE_TIME / (z - 1.0))
            loop = c * (branch.response / controller.gain)
            sensitivity[i, piece] = 1.0 / _least(np.abs(1.0 + loop))
            delay[i, piece] = _delay_margin(branch.omega, loop)
        unstable = ~_stable(branch, Kp / controller.gain, Ki / controller.gain)
        sensitivity[i, unstable], delay[i, unstable] = np.inf, 0.0
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


def _stable(branch: BranchResponse, Kp: Array, Ki: Array) -> NDArray[np.bool_]:
    """Whether the poles of the sampled loop lie inside the unit circle; gains in V/deg."""
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
    """
    import control

    rows = []
    for branch in BRANCHES:
        for rate in RATES:
            loop = loop_tf(wrist, controller, branch, rate)
            poles = control.feedback(loop, 1).poles()
            stable = bool(np.abs(poles).max() < 1.0 - 1e-9)
            omega = np.geomspace(1e-2, 0.999 * np.pi / SAMPLE_TIME, 1500)
            response = control.frequency_response(loop, omega).complex
            size = np.abs(1.0 + response)
            # From the response, since polynomials in z lose digits at 1 ms.
            gm, pm, _, _, wc, _ = control.stability_margins(
                control.frd(response, omega, smooth=True), returnall=True
            )
            delays = np.mod(np.radians(pm), 2 * np.pi) / wc if len(wc) else np.array([np.inf])
            above = [g for g in gm if g > 1.0]
            rows.append({
                "branch": branch, "rate": rate, "stable": stable,
                "gain_margin": float(min(above, default=np.inf)),
                "phase_margin_deg": float(min(pm, default=np.inf)),
                "delay_margin_s": float(delays.min()) if stable else 0.0,
                "Ms": float(1.0 / size.min()) if stable else float("inf"),
            })  # fmt: skip
    return rows
