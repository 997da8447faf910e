"""What effects beside the loop share: the slopes between which they keep those of its sides."""

from collections.abc import Mapping
from typing import Any

from plants.effects.effect import Linear
from plants.hysteresis.law import SIDES, Side

FLAT = 1e-6
"""Least slope of a branch [deg/kPa] and least gap between two [deg]; flatter and narrower ones count as
these."""


def between(loop: Any, least: float, most: float) -> Linear:
    """The linear part of an effect that adds a slope between two [deg/kPa] to every side of a loop."""
    slopes: Mapping[Side, float] = dict(zip(SIDES, (*loop.steepness, loop.flattest), strict=True))
    steep = {side: max(float(slope), FLAT) for side, slope in slopes.items()}
    return Linear(slopes={side: (1.0 + least / k, 1.0 + most / k) for side, k in steep.items()})
