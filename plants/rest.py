"""Wrists that hold still: at which pressure, and with what memory."""

from typing import Any

import numpy as np

from plants import hysteresis
from plants.effects.effect import Around
from plants.hysteresis import Memory
from plants.wrist import STARTS, Number, Start, State, Wrist

LOWEST, HIGHEST = -300.0, 700.0
"""Pressures [kPa] between which a wrist with curved branches is looked for at rest."""


def at_rest(wrist: Wrist, start: Start = "virgin", angle: Number = 0.0) -> State:
    """The state of a wrist that holds still at an angle [deg], having come there by `start`.

    ``virgin``: never moved from the rest pressure; only at angle 0.  ``line1``,
    ``line2``: arrived in the plus, the minus direction.  ``inside``: half-way in
    pressure between the two lines, as after a reversal.  Effects have come to
    rest too: what creeps has crept, the supply is full, no work has been done.
    Raises ValueError for an unknown start or a virgin wrist away from 0.
    """
    p = wrist.hysteresis
    if start not in STARTS:
        raise ValueError(f"unknown start {start!r}; one of {', '.join(STARTS)}")
    virgin = float(start == "virgin")
    if virgin and np.any(np.asarray(angle) != 0.0):
        raise ValueError("a virgin wrist rests at angle 0; start on line1, line2 or inside")
    h = _static_angle(wrist, angle) if wrist.effects and not virgin else angle
    if virgin:
        pressure = p.rest_pressure
    elif not wrist.effects:
        low, high = hysteresis.line2_pressure(h, p), hysteresis.line1_pressure(h, p)
        pressure = {"line1": high, "line2": low, "inside": (low + high) / 2}[start]
    else:
        low, high = _pressure_on(wrist, 1, h), _pressure_on(wrist, 0, h)
        pressure = {"line1": high, "line2": low, "inside": (low + high) / 2}[start]
    return State(pressure, Memory(h, virgin), angle, _effects(wrist, pressure, h))


def _effects(wrist: Wrist, pressure: Number, h: Number) -> tuple[Any, ...]:
    return tuple(e.rest(wrist, pressure, h) for e in wrist.effects)


def _static_angle(wrist: Wrist, angle: Number) -> Number:
    """The loop's angle [deg] from which the effects make the angle that is held; by secants."""
    c = wrist.sampled()

    def held(h: Number) -> Number:
        s = _effects(wrist, wrist.hysteresis.rest_pressure, h)
        after = h
        for i, effect in c.at("static"):
            _, _, after = effect(s[i], h, after, Around())
        return after - angle

    h0 = np.asarray(angle, float)
    h1 = h0 + 0.1
    f0, f1 = held(h0), held(h1)
    for _ in range(20):
        slope = np.where(np.abs(f1 - f0) > 1e-12, (f1 - f0) / np.where(h1 == h0, 1.0, h1 - h0), 1.0)
        h0, f0 = h1, f1
        h1 = h1 - f1 / slope
        f1 = held(h1)
    return h1


def _pressure_on(wrist: Wrist, line: int, h: Number) -> Number:
    """The pressure [kPa] at which line 1 (0) or line 2 (1) has the angle h [deg]; by bisection."""
    c, loop = wrist.sampled(), wrist.hysteresis

    def angle(pressure: Number) -> Number:
        s = _effects(wrist, pressure, h)
        driven = pressure
        for i, effect in c.at("drive"):
            _, _, driven = effect(s[i], driven, driven, Around())
        found = (hysteresis.line1, hysteresis.line2)[line](driven, loop)
        for i, effect in c.at("bend"):
            found = found + effect(s[i], driven, driven, loop, Around())[1 + line]
        return found

    low, high = np.broadcast_arrays(LOWEST, HIGHEST, h)[:2]
    for _ in range(60):
        middle = 0.5 * (low + high)
        below = angle(middle) < h
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return 0.5 * (low + high)
