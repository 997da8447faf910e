"""One sample of the wrist drive system: regulator, hysteresis and lag in series, with effects at their ports.

State in, state out; what belongs to a sample time is in the coefficients (`plants.wrist.Wrist.sampled`).
"""

from typing import Any, NamedTuple

from plants import lag
from plants.actuator import regulator
from plants.effects.effect import Around
from plants.hysteresis import Bend, HysteresisLaw
from plants.meanings import remembers

Number = Any


@remembers(pressure=("kPa", "pressure of the model"), angle=("deg", "angle of the model"))
class State(NamedTuple):
    """State of the wrist: pressure [kPa], the memory of its hysteresis, which has the static angle
    `h` [deg], angle [deg], and the state of each effect."""

    pressure: Number
    memory: Any
    angle: Number
    effects: tuple[Any, ...] = ()


class SampledWrist(NamedTuple):
    """Coefficients of the wrist, and of each effect, for one sample time."""

    regulator: regulator.SampledRegulator
    hysteresis: HysteresisLaw
    lag: lag.SampledLag
    effects: tuple[Any, ...] = ()

    def at(self, port: str) -> list[tuple[int, Any]]:
        """The effects that act at a port, with their places, in order."""
        return [(i, getattr(e, port)) for i, e in enumerate(self.effects) if hasattr(e, port)]

    @property
    def driving(self) -> list[tuple[int, Any]]:
        """Those at the port ``drive`` that change the pressure, and do not only watch it (`watches`)."""
        watching = {i for i, e in enumerate(self.effects) if getattr(e, "watches", False)}
        return [(i, effect) for i, effect in self.at("drive") if i not in watching]


QUIET = Around()
"""Surroundings that disturb nothing: the other motion at rest."""


def step(state: State, command: Number, c: SampledWrist, around: Around = QUIET) -> State:
    """The wrist one sample later, the command [V] held in between."""
    pressure, effects = press(state, command, c, around)
    return bend(state, pressure, effects, c, around)


def press(
    state: State, command: Number, c: SampledWrist, around: Around = QUIET
) -> tuple[Number, tuple[Any, ...]]:
    """First half of a step: pressure [kPa] after the sample, and the states of the effects."""
    s = list(state.effects)
    target = c.regulator.gain * command
    for i, effect in c.at("target"):
        s[i], target = effect(s[i], target, around)
    error, speeds = target - state.pressure, []
    for i, effect in c.at("valve"):
        error, speed = effect(s[i], state.pressure, error, around)
        speeds.append(speed)
    share = regulator.share(error, c.regulator)
    for speed in speeds:
        share = speed * share * (1.0 + 0.5 * (1.0 - speed) * share)  # of 1 - exp(-speed k dt), to 2nd order
    after = state.pressure + share * error
    for i, effect in c.at("chamber"):
        after = effect(s[i], state.pressure, target, after)
    for i, effect in c.at("supply"):
        s[i], after = effect(s[i], state.pressure, after)
    return after, tuple(s)


def bend(
    state: State, pressure: Number, effects: tuple[Any, ...], c: SampledWrist, around: Around = QUIET
) -> State:
    """Second half of a step: the wrist as its pressure [kPa] has moved on."""
    s, loop, bend_by = list(effects), c.hysteresis, None
    before, after = state.pressure, pressure
    for i, effect in c.at("drive"):
        s[i], before, after = effect(s[i], before, after, around)
    for i, effect in c.at("bend"):
        s[i], *shifts = effect(s[i], before, after, loop, around)
        more = Bend(*shifts)
        bend_by = (
            more
            if bend_by is None
            else Bend(bend_by.low + more.low, bend_by.high + more.high, bend_by.slope * more.slope)
        )
    for i, effect in c.at("steepen"):
        factor = effect(s[i], state.memory.h, before, after, loop)
        bend_by = Bend(0.0, 0.0, 1.0) if bend_by is None else bend_by
        bend_by = bend_by._replace(slope=bend_by.slope * factor)
    memory = loop.step(state.memory, before, after, bend_by)

    before, after = state.memory.h, memory.h
    for i, effect in c.at("static"):
        s[i], before, after = effect(s[i], before, after, around)
    s, angle = turned(state.angle, s, before, after, pressure, c)
    for i, effect in c.at("stop"):
        angle = effect(s[i], angle)
    return State(pressure, memory, angle, tuple(s))


def turned(
    angle: Number, effects: list[Any], before: Number, after: Number, pressure: Number, c: SampledWrist
) -> tuple[list[Any], Number]:
    """The joint one sample later: states of the effects and the angle [deg], while the static angle moves
    from `before` to `after` [deg] under a pressure [kPa]."""
    joints, frictions = c.at("joint"), c.at("friction")

    def under(friction: Number) -> tuple[list[Any], Number]:
        s, to = list(effects), lag.step(angle, before - friction, after - friction, c.lag)
        for i, effect in joints:
            s[i], to = effect(effects[i], angle, before - friction, after - friction, pressure)
        return s, to

    if not frictions:
        return under(0.0)
    free = under(0.0)[1]
    share = free - under(1.0)[1] if joints else c.lag.before + c.lag.after
    (i, rubs), *_ = frictions
    rubbed, friction = rubs(effects[i], angle, free, share)
    s, to = under(friction)
    s[i] = rubbed
    return s, to


def settled(state: State, c: SampledWrist, around: Around) -> State:
    """The state with the angle [deg] where it comes to rest in its surroundings, such as a pressure of
    the other motion that moves it."""
    angle = state.memory.h
    for i, effect in c.at("static"):
        _, _, angle = effect(state.effects[i], angle, angle, around)
    return state._replace(angle=angle)


def read(state: State, c: SampledWrist, around: Around = QUIET) -> Number:
    """What the sensor shows of the angle [deg] at the time of `around`."""
    angle = state.angle
    for i, effect in c.at("sensor"):
        angle = effect(state.effects[i], angle, around)
    return angle
