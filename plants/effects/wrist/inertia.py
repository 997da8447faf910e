"""Inertia: the joint overshoots and rings; a second-order transient takes the lag's place.

    inertia^2 y'' + Tw y' + y = h

so that at inertia 0 the declared lag is left.  With wn = 1 / inertia the damping
ratio is Tw / (2 inertia).
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from plants.effects.effect import Effect, Linear, Number, parameter
from plants.effects.hints import ExcitationHints
from plants.meanings import remembers
from plants.second_order import NULL, second_order_hold

MASSLESS = 0.001
"""Inertia [s] below which a joint has none that any log could show."""


@remembers(velocity=("deg/s", "velocity of the joint"))
class Velocity(NamedTuple):
    """Velocity of the joint [deg/s]."""

    velocity: Number


class SampledInertia(NamedTuple):
    """First-order hold of the second-order transient: what angle, velocity and the static angle at
    both ends of the sample give to angle and velocity; the drag per sample [1/deg]; the sample [s]."""

    yy: Number
    yv: Number
    yb: Number
    ya: Number
    vy: Number
    vv: Number
    vb: Number
    va: Number
    drag: Number
    dt: Number

    def joint(
        self, s: Velocity, angle: Number, before: Number, after: Number, pressure: Number
    ) -> tuple[Velocity, Number]:
        new = self.yy * angle + self.yv * s.velocity + self.yb * before + self.ya * after
        velocity = self.vy * angle + self.vv * s.velocity + self.vb * before + self.va * after
        velocity = velocity / (1.0 + self.drag * np.abs(velocity))
        return Velocity(velocity), new


def _transient(inertia: Number, wrist: Any, dt: float, drag: Number = 0.0) -> SampledInertia:
    return SampledInertia._make((*second_order_hold(inertia, wrist.Tw, dt), drag, dt))


@dataclass(frozen=True)
class _Inert(Effect):
    """What the forms share; small motions show neither drag nor a change of stiffness."""

    NAME = "inertia"
    STAGE = "wrist"
    HAPPENS = "The joint has inertia"
    JOINT = True
    BOUND = "kept"

    inertia: Number = parameter("s", "1 / natural frequency", 0.0, 1.0, 0.0, (0.05, 0.1, 0.18))

    def joint_lags(self, wrist: Any) -> tuple[Number, ...]:
        """The two poles of the transient, two halves of Tw where it rings."""
        root = max(wrist.Tw**2 - 4.0 * self.inertia**2, 0.0) ** 0.5
        return (wrist.Tw + root) / 2, (wrist.Tw - root) / 2

    def borrowed(self, asked: ExcitationHints) -> str | None:
        """Without a mass, what else a form has is of the lag."""
        if float(self.inertia) < MASSLESS:
            return "the fit has a lag that changes and no mass; record quick steps, after which a mass swings"
        return None

    def redundant(self, wrist: Any) -> bool:
        """A friction that takes the joint's place leaves it nothing to do."""
        return any(e.MASSLESS for e in wrist.effects)

    def no_bound(self, wrist: Any) -> str | None:
        return "only linear damping has an impulse response"

    def rest(self, wrist: Any, pressure: Number, angle: Number) -> Velocity:
        return Velocity(0.0)

    def linear(self, wrist: Any, z: Any, dt: float, reach: tuple[float, float]) -> Linear:
        c = _transient(self.inertia, wrist, dt)
        # Cramer's rule on (zI - A)(angle, velocity) = before + after z.
        own, speed = c.yb + c.ya * z, c.vb + c.va * z
        determinant = (z - c.yy) * (z - c.vv) - c.yv * c.vy
        return Linear(joint=(own * (z - c.vv) + c.yv * speed) / determinant)


@dataclass(frozen=True)
class Inertia(_Inert):
    """The joint's inertia with linear damping; `inertia` [s] is 1 / wn.

    Its impulse response is positive for ever where its poles are real, and for the first half period where
    it rings, which is how long a performance bound is claimed.
    """

    FORM = "linear damping"

    def sampled(self, wrist: Any, dt: float) -> SampledInertia:
        return _transient(self.inertia, wrist, dt)

    def no_bound(self, wrist: Any) -> str | None:
        if any(e.STOPS for e in wrist.effects):
            return "a stop within a second-order transient is no monotone map"
        return None

    def bound_ends(self, wrist: Any) -> float | None:
        m = self.inertia**2
        if self.inertia <= NULL or wrist.Tw >= 2.0 * self.inertia:
            return None
        ringing = np.sqrt(4.0 * m - wrist.Tw**2) / (2.0 * m)  # rad/s
        return float(np.pi / ringing)


class SampledStiffening(NamedTuple):
    """The linear transient, rest pressure [kPa], and the change of stiffness per kPa from it."""

    linear: SampledInertia
    rest_pressure: Number
    stiffening: Number

    def joint(
        self, s: Velocity, angle: Number, before: Number, after: Number, pressure: Number
    ) -> tuple[Velocity, Number]:
        # A stiffness 1 + k pulls like a stiffness of 1 towards h + k (h - y).
        pull = self.stiffening * (pressure - self.rest_pressure)
        moved = 0.5 * s.velocity * self.linear.dt  # to the middle of the sample
        extra = pull * (0.5 * (before + after) - angle - moved)
        return self.linear.joint(s, angle, before + extra, after + extra, pressure)


@dataclass(frozen=True)
class StiffeningInertia(_Inert):
    """As `Inertia`, the joint being stiffer the more pressure its muscles are under."""

    FORM = "stiffness that changes with the pressure"
    FROM_REST = True

    stiffening: Number = parameter(
        "1", "change of stiffness over half the range", -0.9, 2.0, 0.0, (-0.3, 0.3)
    )

    def sampled(self, wrist: Any, dt: float) -> SampledStiffening:
        return SampledStiffening(
            _transient(self.inertia, wrist, dt),
            wrist.hysteresis.rest_pressure,
            self.stiffening / wrist.rig.half_range,
        )


@dataclass(frozen=True)
class DraggedInertia(_Inert):
    """As `Inertia`, with a drag that goes with the square of the speed; below zero the joint is damped less
    the faster it is, as under dry friction."""

    FORM = "damping that changes with the speed"

    drag: Number = parameter("1/deg", "drag: deceleration over velocity squared", -0.05, 1.0, 0.0, (0.03,))

    def sampled(self, wrist: Any, dt: float) -> SampledInertia:
        return _transient(self.inertia, wrist, dt, self.drag * dt)
