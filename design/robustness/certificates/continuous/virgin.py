"""How long a step from rest stays on the virgin curve, which has slope 0, occurs once and is no vertex.

On it h = 0 and y = 0, so the error is the reference r all the while, whatever filters the angle, and the PI's
command a ramp, b being its weight of the reference,

    gain v = rest + c(t),    c(t) = b Kp r + Ki r t,  up to the end of the range and then held there
                                                    (the integrator stops),

and the pressure above rest, p, follows it by dp/dt = k(q) q, q = c - p, with k between k_slow and
k_fast.  As q never changes its sign, p lies between its values at the two rates (comparison lemma,
H. K. Khalil, Nonlinear Systems, 3rd ed., lemma 3.4), each in closed form:

    p = c0 (1 - exp(-k t)) + c1 (t - (1 - exp(-k t)) / k)           on a ramp c0 + c1 t.

The curve is left where p reaches w1 / a1 upwards, w2 / a2 downwards.
"""

from dataclasses import dataclass

import numpy as np

from design.controllers.pi import PI
from plants.wrist import Wrist


@dataclass(frozen=True)
class Stuck:
    """The command comes no further than `furthest` [kPa] from rest, upwards or downwards, and the line is
    met at `threshold` [kPa]."""

    furthest: float
    up: bool
    threshold: float


@dataclass(frozen=True)
class VirginBounds:
    """Bounds of the time [s] at which a step leaves the virgin curve, from when the command reaches the
    regulator, and of |gain v - P| [kPa] at that moment; infinite where a loop at that rate never does,
    and then `stuck` says what keeps it there; clipped: whether the command may reach the end of its
    range before."""

    threshold: float
    earliest: float
    latest: float
    q_least: float
    q_most: float
    clipped: bool = False
    stuck: Stuck | None = None

    @property
    def leaves(self) -> bool:
        """Whether every loop with rates between the two leaves the curve."""
        return bool(np.isfinite(self.latest))


@dataclass(frozen=True)
class _Ramp:
    """c0 + c1 t up to the end of the range [kPa], all counted in the direction of the step."""

    c0: float
    c1: float
    end: float

    @property
    def clipped_at(self) -> float:
        """Time [s] from which the command is held at the end of its range."""
        if self.c0 >= self.end:
            return 0.0
        return (self.end - self.c0) / self.c1 if self.c1 > 0.0 else np.inf

    def at(self, t: float) -> float:
        """The command above rest [kPa]."""
        return min(self.c0 + self.c1 * t, self.end) if self.c1 > 0.0 else min(self.c0, self.end)

    def pressure(self, t: float, k: float) -> float:
        """The pressure above rest [kPa] at a rate k [1/s]."""
        before = min(t, self.clipped_at)
        gone = -np.expm1(-k * before)
        p = self.c0 * gone + self.c1 * (before - gone / k)
        if t > before:
            p = self.end - (self.end - p) * np.exp(-k * (t - before))
        return float(p)


def time_on_virgin_curve(wrist: Wrist, controller: PI, reference: float) -> VirginBounds:
    """Bounds of the time that a step of `reference` [deg] from rest spends on the virgin curve.

    Plants with effects are taken for the declared wrist behind them; a dead time comes on top.
    A step that cannot leave the curve has infinite times.

    >>> from plants import Wrist
    >>> from design.controllers.pi import PI
    >>> found = time_on_virgin_curve(Wrist.flexion(), PI(1.2, 2.2), 15.0)
    >>> round(found.earliest, 3), round(found.latest, 3)
    (0.167, 1.072)
    >>> stuck = time_on_virgin_curve(Wrist.flexion(), PI(1.0, 0.0), 15.0).stuck
    >>> stuck.furthest, stuck.up, round(stuck.threshold, 3)
    (15.0, True, 16.667)
    """
    p, up, size = wrist.hysteresis, reference >= 0.0, abs(reference)
    gain, rest = float(wrist.regulator.gain), float(p.rest_pressure)
    meets = (p.ascending_pressure if up else p.descending_pressure)(0.0)
    threshold = abs(float(meets) - rest) if p.DEAD_ZONE else 0.0
    end = gain * controller.high - rest if up else rest - gain * controller.low
    ratio, b = gain / controller.gain, float(getattr(controller, "b", 1.0))
    ramp = _Ramp(ratio * b * controller.Kp * size, ratio * controller.Ki * size, float(end))
    slow, fast = sorted((float(wrist.regulator.k_slow), float(wrist.regulator.k_fast)))
    furthest = ramp.end if ramp.c1 > 0.0 else min(ramp.c0, ramp.end)
    if furthest <= threshold:
        stuck = Stuck(float(furthest), up, threshold)
        return VirginBounds(threshold, np.inf, np.inf, np.nan, np.nan, ramp.clipped_at < np.inf, stuck)
    earliest, latest = _reached(ramp, threshold, fast), _reached(ramp, threshold, slow)
    q = [ramp.at(t) - threshold for t in (earliest, latest)]
    return VirginBounds(threshold, earliest, latest, q[0], q[1], ramp.clipped_at <= latest)


def _reached(ramp: _Ramp, threshold: float, k: float) -> float:
    """When the pressure at a rate reaches a threshold [kPa] that the command goes beyond."""
    from scipy.optimize import brentq

    if threshold <= 0.0:
        return 0.0
    high = 1.0 / k
    while ramp.pressure(high, k) < threshold:
        high *= 2.0
    return float(brentq(lambda t: ramp.pressure(t, k) - threshold, 0.0, high, xtol=1e-12))
