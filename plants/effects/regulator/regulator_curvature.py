"""Regulator curvature: the pressure at rest is a curve over the command, not a straight line.

A syringe compresses a closed volume V of air by its stroke v, P = 100 kPa v / (V - v), and a pump that
meets a leak gives less and less: both are hyperbolas.  With a command of zero the pressure is zero, as on the
straight line, and the gain of the regulator is the slope there.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from plants.effects.effect import Around, Effect, Linear, Nothing, Number, parameter
from plants.hysteresis import SIDES

LEAST = 0.1
"""Least denominator of the curve, so that it has no pole: from there on it is a line through zero."""


class SampledHyperbola(NamedTuple):
    """Curvature [1/kPa]."""

    curvature: Number

    def valve(self, s: Nothing, pressure: Number, error: Number, around: Around) -> tuple[Number, Number]:
        return pressure + error - self._straight(pressure), 1.0

    def chamber(self, s: Nothing, before: Number, target: Number, after: Number) -> Number:
        moved = self._straight(before) + after - before
        return moved / np.maximum(1.0 - self.curvature * moved, LEAST)

    def _straight(self, pressure: Number) -> Number:
        """What gives a pressure [kPa]."""
        return pressure * np.maximum(1.0 / np.maximum(1.0 + self.curvature * pressure, LEAST), LEAST)


@dataclass(frozen=True)
class Hyperbola(Effect):
    """The pressure is P = Q / (1 - curvature Q / R), with the range R of the pressure, and Q follows the
    commanded pressure as a regulator's does: the slope over the command is (1 + curvature P / R)^2 times that
    at zero."""

    NAME = "regulator-curvature"
    STAGE = "regulator"
    FORM = "hyperbola of the command"
    HAPPENS = "The pressure is a curve over the command"
    REGULATES = False
    FIRST = True  # the regulator's laws are of what is still straight
    BOUND = "kept"

    curvature: Number = parameter(
        "1", "root of the slope at one range above zero, less 1", -0.7, 2.0, 0.0, (-0.2, 0.2)
    )

    def sampled(self, wrist: Any, dt: float) -> SampledHyperbola:
        return SampledHyperbola(self.curvature / (2.0 * wrist.rig.half_range))

    def linear(self, wrist: Any, z: Any, dt: float, reach: tuple[float, float]) -> Linear:
        """The slopes of the curve within pressures [kPa] go to those of the loop."""
        roots = [max(1.0 + self.curvature * p / (2.0 * wrist.rig.half_range), 0.0) for p in reach]
        return Linear(slopes=dict.fromkeys(SIDES, (min(roots) ** 2, max(roots) ** 2)))
