"""Wrists that hold still: at which pressure, and with what memory."""

from typing import TYPE_CHECKING, Any

import numpy as np

from plants import lag
from plants.dynamics import Number, SampledWrist, State, press
from plants.effects.effect import Around
from plants.hysteresis import STARTS, Start

if TYPE_CHECKING:
    from plants.wrist import Wrist

BEYOND = (1.5, 2.5)
"""By how many spans below and above the range of its pressure a wrist with effects is looked for at rest."""

TRIED = 40
"""Pressures that are tried in a span before the rest is narrowed down."""

MOST_ABOVE = 2.0
"""By how many spans of its range at most the commanded pressure is looked for above the one that is held."""

HELD = 1e-9
"""Share of half the range of the pressure by which one that is held moves in a sample at most."""

SECANTS, NEAR = 20, 1e-10
"""Steps in which a pressure and what effects add at it are brought together, and how near [deg]."""


def searched(wrist: "Wrist") -> tuple[float, float, float]:
    """Pressures between which a wrist with effects is looked for at rest (one that is found at an end of them
    rests nowhere), and how far apart they are tried at first."""
    low, high = wrist.rig.pressure_range
    span = high - low
    return low - BEYOND[0] * span, high + BEYOND[1] * span, span / TRIED


def at_rest(wrist: "Wrist", start: Start = "virgin", angle: Number = 0.0) -> State:
    """The state of a wrist that holds still at an angle [deg], having come there by `start`.

    ``virgin``: never moved from the rest pressure; only at angle 0.  ``line1``,
    ``line2``: arrived in the plus, the minus direction.  ``inside``: half-way in
    pressure between the two lines, as after a reversal.  Effects have come to
    rest too: what creeps has crept, the supply is full, no work has been done.
    An angle that effects keep the wrist from gets a state that does not last:
    `obstacle` says so.  Raises ValueError for an unknown start or a virgin wrist away from 0.
    """
    loop = wrist.hysteresis
    if start not in STARTS:
        raise ValueError(f"unknown start {start!r}; one of {', '.join(STARTS)}")
    virgin = start == "virgin"
    if virgin and np.any(np.asarray(angle) != 0.0):
        raise ValueError("a virgin wrist rests at angle 0; start on line1, line2 or inside")
    if virgin:
        # A law without a dead zone of its own leaves the initial curve with the slightest pressure.
        state = State(loop.rest_pressure, loop.initial(), angle)
        return state._replace(effects=effects_at_rest(wrist, state.pressure, angle))
    if not wrist.effects:
        pressure = loop.rest_between(angle)[start]
        return State(pressure, loop.resting(start, angle, pressure), angle)
    pressure, h = _resting(wrist, start, angle)
    return State(pressure, _memory(wrist, start, h, pressure), angle, effects_at_rest(wrist, pressure, h))


def _resting(wrist: "Wrist", start: Start, angle: Number) -> tuple[Number, Number]:
    """Pressure [kPa] and angle of the loop [deg] of a wrist that rests at an angle [deg].

    What effects add beside the loop depends on the pressure, which is found together with it: by secants.
    """

    def found(of_loop: Number) -> tuple[Number, Number]:
        h = static_angle(wrist, of_loop)
        low, high = _pressure_on(wrist, 1, h), _pressure_on(wrist, 0, h)
        return {"line1": high, "line2": low, "inside": (low + high) / 2}[start], h

    t0 = np.asarray(angle, float)
    pressure, h = found(t0)
    f0 = beside(wrist, pressure)
    if not np.any(f0):
        return pressure, h
    t1 = t0 - f0
    for _ in range(SECANTS):
        pressure, h = found(t1)
        f1 = t1 + beside(wrist, pressure) - angle
        if np.all(np.abs(f1) < NEAR):
            break
        slope = np.where(t1 == t0, 1.0, (f1 - f0) / np.where(t1 == t0, 1.0, t1 - t0))
        t0, f0, t1 = t1, f1, t1 - f1 / np.where(np.abs(slope) > NEAR, slope, 1.0)
    return pressure, h


def beside(wrist: "Wrist", pressure: Number) -> Number:
    """Angle [deg] that effects add to the loop's at rest at a pressure [kPa]."""
    return sum((e.beside(wrist, pressure) for e in wrist.effects), 0.0)


def _memory(wrist: "Wrist", start: Start, h: Number, pressure: Number) -> Any:
    """The memory at rest of a loop that effects drive and bend."""
    driven, down, up = _bent(wrist, wrist.sampled(), pressure, h)
    return wrist.hysteresis.resting(start, h, driven, down, up)


def effects_at_rest(
    wrist: "Wrist", pressure: Number, h: Number, *ports: str, sampled: SampledWrist | None = None
) -> tuple[Any, ...]:
    """States of the effects of a wrist that holds still at a pressure [kPa], its loop at h [deg]; where ports
    are named, None of those that act at none of them: what is commanded, which a leak makes a search, is
    found only for whom it matters.  sampled: the wrist's coefficients, where they are at hand."""
    c = wrist.sampled() if sampled is None else sampled
    asked = {i for i, _ in c.at("target")}
    wanted = {i for port in ports for i, _ in c.at(port)} if ports else set(range(len(wrist.effects)))
    aimed = commanded(wrist, pressure) if asked & wanted else pressure
    return tuple(
        e.rest(wrist, aimed if i in asked else pressure, h) if i in wanted else None
        for i, e in enumerate(wrist.effects)
    )


def holding_command(wrist: "Wrist", pressure: Number) -> Number:
    """The command [V] under which the pressure [kPa] of a wrist stays where it is.

    >>> from plants import Wrist
    >>> from plants.effects.regulator.leak import LaminarLeak
    >>> round(float(holding_command(Wrist.flexion(), 98.8)), 9)
    2.0
    >>> round(float(holding_command(Wrist.flexion() + LaminarLeak(0.05), 98.8)), 3)
    2.066
    """
    return commanded(wrist, pressure) / wrist.regulator.gain


def commanded(wrist: "Wrist", pressure: Number) -> Number:
    """The commanded pressure [kPa] at which the regulator gives what a wrist at a pressure [kPa] loses, or
    valves let in what they let out, outside the command's range where none does: the pressure itself, where
    neither is; by bisection."""
    regulated = all(e.REGULATES for e in wrist.effects)
    if regulated and not any(e.LOSES for e in wrist.effects):
        return pressure
    c = wrist.sampled()
    prompt = [e for e, law in zip(wrist.effects, c.effects, strict=True) if not hasattr(law, "target")]
    c = c._replace(effects=tuple(e.sampled(wrist, wrist.rig.sample_time) for e in prompt))
    still = State(pressure, None, 0.0, tuple(e.rest(wrist, pressure, 0.0) for e in prompt))
    low = pressure + 0.0 * press(still, 0.0, c)[0]
    high = low + MOST_ABOVE * (wrist.rig.pressure_range[1] - wrist.rig.pressure_range[0])
    if not regulated:
        low, high = (0.0 * low + wrist.regulator.gain * v for v in wrist.rig.command_range)
    for _ in range(60):
        middle = 0.5 * (low + high)
        sinks = press(still, middle / wrist.regulator.gain, c)[0] < pressure
        low, high = np.where(sinks, middle, low), np.where(sinks, high, middle)
    if regulated:
        return high
    moves = press(still, high / wrist.regulator.gain, c)[0] - pressure
    span = wrist.regulator.gain * float(np.ptp(wrist.rig.command_range))
    return high - np.where(np.abs(moves) > HELD * wrist.rig.half_range, np.sign(moves) * span, 0.0)


def at_pressure(wrist: "Wrist", start: Start, pressure: float) -> State:
    """The state of a wrist that holds still on ``line1`` or ``line2`` at a pressure [kPa]."""
    h, held = (float(angle) for angle in angles_at(wrist, start, pressure))
    if not wrist.effects:
        return at_rest(wrist, start, held)
    return State(pressure, _memory(wrist, start, h, pressure), held, effects_at_rest(wrist, pressure, h))


def angles_at(wrist: "Wrist", start: Start, pressure: Number) -> tuple[Number, Number]:
    """Angles [deg] of the loop and of the joint of a wrist that holds still on ``line1`` or ``line2`` at
    pressures [kPa], stops left out."""
    line, loop = {"line1": 0, "line2": 1}[start], wrist.hysteresis
    if not wrist.effects:
        h = (loop.ascending, loop.descending)[line](pressure)
        return h, h
    h = _line_angle(wrist, wrist.sampled(), line, pressure, 0.0)
    return h, _held_angle(wrist, h) + beside(wrist, pressure)


def driving_pressure(wrist: "Wrist", pressure: Number) -> Number:
    """The pressure [kPa] that drives the loop of a wrist that holds still at a pressure [kPa]: another where
    effects come between the two."""
    return _bent(wrist, wrist.sampled(), pressure, 0.0)[0]


def obstacle(wrist: "Wrist", start: Start, angle: float) -> str | None:
    """What keeps a wrist from holding still at an angle [deg] on ``line1`` or ``line2``, in words; None
    where nothing does.  Whether a command in the range gives the pressure is not asked."""
    if not wrist.effects:
        return None
    pressure = float(at_rest(wrist, start, angle).pressure)
    for effect in wrist.effects:
        words = effect.obstacle(pressure, angle)
        if words is not None:
            return words
    lowest, highest, _ = searched(wrist)
    return None if lowest < pressure < highest else f"a branch that no pressure takes to {angle:+g} deg"


def _held_angle(wrist: "Wrist", h: Number) -> Number:
    """The angle [deg] at which the effects let a wrist rest whose loop is at h [deg]; stops left out."""
    c = wrist.sampled()
    s = effects_at_rest(wrist, wrist.hysteresis.rest_pressure, h, "static", sampled=c)
    after = h
    for i, effect in c.at("static"):
        _, _, after = effect(s[i], h, after, Around())
    return after


def static_angle(wrist: "Wrist", angle: Number, against: bool = True) -> Number:
    """The loop's angle [deg] from which the effects make the angle that is held; by secants.  against:
    whether a stop may hold the joint, so that the loop is further on."""
    stops = wrist.sampled().at("stop") if against else []

    def held(h: Number) -> Number:
        static = _held_angle(wrist, h)
        if not stops:
            return static - angle
        # A joint that rests against a stop: the lag pulls it on and the stop pushes it back.
        moved = lag.step(angle, static, static, wrist.sampled().lag)
        for i, effect in stops:
            moved = effect(effects_at_rest(wrist, wrist.hysteresis.rest_pressure, h, "stop")[i], moved)
        return moved - angle

    h0 = np.asarray(angle, float)
    h1 = h0 + 0.1
    f0, f1 = held(h0), held(h1)
    for _ in range(20):
        if np.all(np.abs(f1) < 1e-12):
            break
        slope = np.where(np.abs(f1 - f0) > 1e-12, (f1 - f0) / np.where(h1 == h0, 1.0, h1 - h0), 1.0)
        h0, f0 = h1, f1
        h1 = h1 - f1 / slope
        f1 = held(h1)
    return h1


def _line_angle(wrist: "Wrist", c: SampledWrist, line: int, pressure: Number, h: Number) -> Number:
    """The angle [deg] of line 1 (0) or line 2 (1), as the effects bend it, at a pressure [kPa]."""
    loop = wrist.hysteresis
    driven, *shifts = _bent(wrist, c, pressure, h)
    return (loop.ascending, loop.descending)[line](driven) + shifts[line]


def _bent(wrist: "Wrist", c: SampledWrist, pressure: Number, h: Number) -> tuple[Number, Number, Number]:
    """The pressure [kPa] that drives a loop at rest at a pressure [kPa], and the shifts of its branches
    [deg]."""
    driven, down, up = pressure, 0.0, 0.0
    # Searches for a rest ask often: those that only watch the pressure are not asked.
    drives, bends = c.driving, c.at("bend")
    if not drives and not bends:
        return driven, down, up
    ports = [name for name, those in (("drive", drives), ("bend", bends)) if those]
    loop, s = wrist.hysteresis, effects_at_rest(wrist, pressure, h, *ports, sampled=c)
    for i, effect in drives:
        _, _, driven = effect(s[i], driven, driven, Around())
    for i, effect in bends:
        _, low, high, _ = effect(s[i], driven, driven, loop, Around())
        down, up = down + low, up + high
    return driven, down, up


def _pressure_on(wrist: "Wrist", line: int, h: Number) -> Number:
    """The pressure [kPa] at which line 1 (0) or line 2 (1) has the angle h [deg]; by bisection.

    A curved line may have it more than once: of the pressures where the line rises
    through it, the nearest to the rest pressure is taken.
    """

    c = wrist.sampled()  # once: it is asked for at each step of the bisection

    def below(pressure: Number) -> Number:
        return _line_angle(wrist, c, line, pressure, h) < h

    shape = np.shape(below(wrist.hysteresis.rest_pressure))
    lowest, highest, spacing = searched(wrist)
    grid = np.arange(lowest, highest + spacing, spacing).reshape(-1, *(1 for _ in shape))
    under = np.broadcast_to(below(grid), (len(grid), *shape))
    rises = under[:-1] & ~under[1:]
    far = np.abs(grid[:-1] + 0.5 * spacing - wrist.hysteresis.rest_pressure)
    nearest = np.where(rises, far, np.inf).argmin(axis=0)
    low = lowest + spacing * nearest
    # Where it rises through it nowhere, the end that is nearer to it.
    nowhere, high = ~rises.any(axis=0), low + spacing
    low = np.where(nowhere, np.where(under[-1], highest, lowest), low)
    high = np.where(nowhere, low, high)
    for _ in range(50):
        middle = 0.5 * (low + high)
        small = below(middle)
        low, high = np.where(small, middle, low), np.where(small, high, middle)
    return 0.5 * (low + high)
