"""Baselines: the paper's PI, and the textbook rules from a reaction curve.

The rules see what a plant engineer would see: a step of the pressure command and the
angle that follows, fitted with a first-order lag and a dead time.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.controllers.pi import PI
from plants.effects.effect import dead_time_of
from plants.equilibrium import at_pressure
from plants.wrist import Wrist

Array = NDArray[np.float64]

PAPER_GAINS = (1.2, 2.2)
"""Stand-in for the paper's gains, which its text lost: Kp [kPa/deg], Ki [kPa/(deg s)].  Assumed,
because a PI with them settles in 5 to 8 s, which is how slow the paper reads."""

PAPER_FACTOR = 1.5
"""Either gain of the stand-in may be off by this factor; a range is carried through comparisons."""


@dataclass(frozen=True)
class Reaction:
    """First-order lag with dead time, fitted to a reaction curve.

    gain [deg/kPa], time_constant and dead_time [s], rmse [deg] of the fit;
    time [s], angle and fitted [deg], (n,), for drawing.
    """

    gain: float
    time_constant: float
    dead_time: float
    rmse: float
    time: Array
    angle: Array
    fitted: Array


def paper_range() -> list[tuple[float, float]]:
    """The stand-in for the paper's gains and the four corners of the range around it."""
    Kp, Ki = PAPER_GAINS
    factors = (1.0 / PAPER_FACTOR, PAPER_FACTOR)
    return [PAPER_GAINS, *((Kp * a, Ki * b) for a in factors for b in factors)]


def first_order(time: Array, gain: Any, time_constant: Any, dead_time: Any) -> Array:
    """Unit-step response of a first-order lag with dead time at times [s]."""
    late = np.maximum(time - dead_time, 0.0)
    response: Array = gain * -np.expm1(-late / time_constant)
    return response


def reaction_curve(wrist: Wrist, duration: float = 5.0) -> Reaction:
    """Simulate the reaction to the step of the command that the rig's task names [kPa], and fit it.

    The wrist starts at rest on line 1 at the lower pressure: from the virgin
    curve the dead zone would be mistaken for dead time.
    """
    from scipy.optimize import least_squares

    low, high = wrist.rig.task.reaction
    start = at_pressure(wrist, "line1", low)
    command = np.full(round(duration / wrist.rig.sample_time), high / wrist.regulator.gain)
    response = wrist.simulate(command, start)
    angle = (response.angle - response.angle[0]) / (high - low)
    seen = slice(None, None, 10)

    def residual(x: Array) -> Array:
        difference: Array = first_order(response.time[seen], *x) - angle[seen]
        return difference

    begin = [np.clip(angle[-1], 2e-4, 9.0), 0.3, 0.05]
    fit = least_squares(residual, begin, bounds=([1e-4, 1e-3, 0.0], [10.0, 10.0, 2.0]))
    gain, time_constant, dead_time = map(float, fit.x)
    fitted = first_order(response.time, *fit.x)
    rmse = float(np.sqrt(np.mean((fitted - angle) ** 2))) * (high - low)
    return Reaction(
        gain, time_constant, dead_time, rmse, response.time, angle * (high - low), fitted * (high - low)
    )


def simc(wrist: Wrist) -> PI:
    """SIMC with the half rule on the lags of line 1: regulator (fast rate), wrist, half a sample.

    Half of the second largest lag goes to the largest, half and all smaller ones to the
    dead time; closed-loop time constant equal to the dead time.  A dead time of the
    wrist's adds to it, its tube is one lag more, and a joint with inertia counts as its
    two lags, two halves of Tw where it rings.  Other effects take no part.
    Skogestad, J. Process Control 13 (2003) 291, doi 10.1016/S0959-1524(02)00062-8.
    """
    large, small, *rest = sorted((1.0 / wrist.regulator.k_fast, *_lags(wrist)), reverse=True)
    lag, dead = large + small / 2, small / 2 + wrist.rig.sample_time / 2
    dead += sum(rest) + dead_time_of(wrist.effects)
    Kp = lag / (wrist.hysteresis.steepness[0] * 2.0 * dead)
    return _pi(wrist, Kp, min(lag, 8.0 * dead))


def _lags(wrist: Wrist) -> list[float]:
    """Time constants [s] of the joint, with inertia those of its two poles, and of what effects add."""
    joint = [lags for e in wrist.effects if (lags := e.joint_lags(wrist)) is not None]
    return [*(joint[-1] if joint else (wrist.Tw,)), *(lag for e in wrist.effects for lag in e.lags(wrist))]


def amigo(wrist: Wrist, r: Reaction) -> PI:
    """AMIGO for PI.

    Astrom & Hagglund, J. Process Control 14 (2004) 635, doi 10.1016/j.jprocont.2004.01.002.
    """
    T, L = r.time_constant, _dead(r, wrist)
    Kp = 0.15 / r.gain + (0.35 - L * T / (L + T) ** 2) * T / (r.gain * L)
    return _pi(wrist, Kp, 0.35 * L + 13.0 * L * T**2 / (T**2 + 12.0 * L * T + 7.0 * L**2))


def ziegler_nichols(wrist: Wrist, r: Reaction) -> PI:
    """Ziegler-Nichols, step-response method for PI; Trans. ASME 64 (1942) 759."""
    T, L = r.time_constant, _dead(r, wrist)
    return _pi(wrist, 0.9 * T / (r.gain * L), L / 0.3)


def _dead(r: Reaction, wrist: Wrist) -> float:
    return max(r.dead_time, wrist.rig.sample_time)  # no rule is defined without a dead time


def _pi(wrist: Wrist, Kp: float, Ti: float) -> PI:
    return PI.of(wrist, Kp, Kp / Ti)


def baselines(wrist: Wrist) -> dict[str, PI]:
    """The baseline controllers of a comparison, by name; the paper's is the stand-in."""
    reaction = reaction_curve(wrist)
    return {
        "paper": PI.of(wrist, *PAPER_GAINS),
        "SIMC": simc(wrist),
        "AMIGO": amigo(wrist, reaction),
        "Ziegler-Nichols": ziegler_nichols(wrist, reaction),
    }
