"""Harmonic balance: the oscillations at which PI, regulator, hysteresis and lag add up to -1.

With an amplitude A of the pressure and a frequency w,

    1 + C(jw) regulator(jw; w A) N(A) lag(jw) = 0,

C the controller's own transfer function, N of the hysteresis and the regulator's own rate K(E) both from
`describing_function`.  The pressure is the integral of k(e) e, so that its amplitude A and frequency w tell
the amplitude of the flow, w A, and this the error E and the rate: the two nonlinearities have one amplitude
between them, and a scan over rates between slow and fast is not needed.  Transfer functions are those of the
sampled loop.

Stability by Loeb's criterion: a cycle attracts where, with 1 + G(A, w) = U + j V,

    dU/dA dV/dw - dV/dA dU/dw > 0

(Gelb & Vander Velde, Multiple-input describing functions and nonlinear system design, 1968):
that is how the curve of -1/N crosses the Nyquist curve as A grows.  Of effects the prediction
knows what is linear in the command, in the static angle and in the joint, such as dead time; the
simulator knows them all.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.controllers.pi import PI
from design.robustness.predictions.describing_function import centre_of, hysteresis_function, regulator_rate
from plants import lag
from plants.wrist import Wrist

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
AMPLITUDES = (0.05, 250.0)
"""Pressures [kPa] between which cycles are looked for; the range of the command is some 200 kPa wide."""

FREQUENCIES = (0.02, 300.0)
"""Frequencies [rad/s] between which they are looked for."""


@dataclass(frozen=True)
class Parts:
    """Frequency responses of the loop without hysteresis and regulator, shape of omega [rad/s]:
    controller [kPa/deg], command (dead time), joint (lag)."""

    z: Complex
    controller: Complex
    command: Complex
    joint: Complex


def parts(wrist: Wrist, controller: PI, omega: Any) -> Parts:
    """The linear parts of the sampled loop at frequencies [rad/s]."""
    z = np.exp(1j * np.asarray(omega, float) * wrist.rig.sample_time)
    p, c = wrist.regulator, lag.sampled(wrist.Tw, wrist.rig.sample_time)
    command, joint = np.ones_like(z), (c.before + c.after * z) / (z - c.keep)
    for part in (e.linear(wrist, z, wrist.rig.sample_time, wrist.reach) for e in wrist.effects):
        command, joint = command * part.command, (joint if part.joint is None else part.joint) * part.static
    known = np.asarray(controller.transfer(z, wrist.rig.sample_time) * p.gain, complex)
    return Parts(z, known, command, joint)


def regulator_response(rate: Any, z: Complex, dt: float) -> Complex:
    """Frequency response of the regulator at one rate [1/s], from commanded to actual pressure;
    dt: sample time [s]."""
    share = -np.expm1(-np.asarray(rate) * dt)
    return np.asarray(share / (z - 1.0 + share), complex)


def loop_gain(wrist: Wrist, controller: PI, amplitude: Any, omega: Any, reference: float = 0.0) -> Complex:
    """G(A, w) of the harmonic balance 1 + G = 0: amplitudes [kPa] in rows, frequencies [rad/s] in columns."""
    A, w = np.atleast_1d(np.asarray(amplitude, float)), np.atleast_1d(np.asarray(omega, float))
    N, _ = hysteresis_function(wrist.hysteresis, A, centre_of(wrist.hysteresis, A, reference))
    known = parts(wrist, controller, w)
    air = regulator_response(regulator_rate(wrist.regulator, A[:, None] * w), known.z, wrist.rig.sample_time)
    return np.asarray(known.controller * known.command * known.joint * air * N[:, None], complex)


def balances(wrist: Wrist, controller: PI, reference: float = 0.0) -> list[tuple[float, float, bool]]:
    """Every (amplitude [kPa], frequency [rad/s], stable) that solves the harmonic balance, by amplitude.

    Cells of a grid over which both the real and the imaginary part of 1 + G change sign start Powell's
    hybrid method.
    """
    from scipy.optimize import root

    A, w = np.geomspace(*AMPLITUDES, 200), np.geomspace(*FREQUENCIES, 500)
    F = 1.0 + loop_gain(wrist, controller, A, w, reference)

    def at(x: Array) -> Array:
        f = 1.0 + loop_gain(wrist, controller, np.exp(x[:1]), np.exp(x[1:]), reference)[0, 0]
        return np.array([f.real, f.imag])

    found: list[tuple[float, float, bool]] = []
    for i, j in zip(*np.nonzero(_straddles(F.real) & _straddles(F.imag)), strict=True):
        begin = np.log([np.sqrt(A[i] * A[i + 1]), np.sqrt(w[j] * w[j + 1])])
        solved = root(at, begin, tol=1e-10)
        near = bool(np.all(np.abs(solved.x - begin) < 3.0 * np.log([A[1] / A[0], w[1] / w[0]])))
        if not near or np.abs(solved.fun).max() > 1e-6:
            continue
        a, o = (float(v) for v in np.exp(solved.x))
        if any(abs(np.log(a / b)) + abs(np.log(o / v)) < 1e-3 for b, v, _ in found):
            continue
        dA = (at(solved.x + [1e-4, 0.0]) - at(solved.x - [1e-4, 0.0])) / 2e-4
        dw = (at(solved.x + [0.0, 1e-4]) - at(solved.x - [0.0, 1e-4])) / 2e-4
        found.append((a, o, bool(dA[0] * dw[1] - dA[1] * dw[0] > 0.0)))
    return sorted(found)


def _straddles(values: Array) -> NDArray[np.bool_]:
    """Whether the corners of each cell of a grid differ in sign."""
    corners = np.stack([values[:-1, :-1], values[1:, :-1], values[:-1, 1:], values[1:, 1:]])
    return np.asarray((corners.min(axis=0) <= 0.0) & (corners.max(axis=0) >= 0.0))
