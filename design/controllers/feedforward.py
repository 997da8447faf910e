"""Inverse-hysteresis feedforward, alone and with a PI: the reference is met by a model that is inverted.

`controllers.reference_model` takes the model to the reference as fast as the range of the command and the
reference filter allow.  `Feedforward` plays the command of the model; `FeedforwardPI` adds a PI on the angle
of the model less the one that is measured (two degrees of freedom: Astrom & Hagglund, Advanced PID Control,
2006).  Both start from the memory that angle and pressure tell (`controllers.memory_estimator`).

Behind a dead time that the model does not have, a step that is taken back leaves the wrist on another branch
than the model, and the next reference would be met by the inverse of the wrong branch.  So `FeedforwardPI`
observes the memory all the while, and its model starts from what is observed whenever the reference leaves
a value that it has held.
"""

from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar, NamedTuple

import numpy as np

from design.controllers.controller import Measured, remembers
from design.controllers.measurement import memory_estimator
from design.controllers.measurement.memory_estimator import (
    MemoryObserver,
    ObserverState,
    SampledObserver,
    memory_at_rest,
    pressure_at_rest,
)
from design.controllers.pi import PI
from design.controllers.reference_model import ReferenceModel, SampledReferenceModel, no_inverse, proceed
from plants.actuator import delay
from plants.actuator.delay import DelayLine, SampledDelay
from plants.dynamics import Number
from plants.effects.effect import dead_time_of
from plants.errors import InputError
from plants.kernel import pytrees
from plants.wrist import COMMAND_RANGE, SAMPLE_TIME, State, Wrist

SPEED = 25.0
"""Rate [1/s] of the reference filter close to the reference, where none is given."""

SAME = 1e-6
"""Difference [deg] below which two references are one: the reference is seen as error plus angle, rounded."""


@dataclass(frozen=True)
class Feedforward:
    """The model, a wrist without effects, and the rate of the reference filter, speed [1/s]; floats or
    arrays of lanes.

    low and high [V] bound the command.  Raises ValueError for a setting that is not finite, a speed that is
    not positive, and a model that has no inverse: a loop that runs backwards within the range of pressure,
    a regulator whose rate falls as the error grows.
    """

    model: Wrist
    speed: Number = SPEED
    low: Number = COMMAND_RANGE[0]
    high: Number = COMMAND_RANGE[1]

    def __post_init__(self) -> None:
        v = {n: np.asarray(x, float) for n, x in self.settings.items()}
        if not all(np.isfinite(x).all() for x in v.values()):
            raise ValueError("settings of a feedforward must be finite")
        if not all((v[n] > 0.0).all() for n in ("gain", "k_fast", "k_slow", "Tw", "speed")):
            raise ValueError("gain, k_fast, k_slow, Tw and speed must be positive")
        if np.any(v["k_slow"] > v["k_fast"]):
            raise ValueError("a regulator with k_slow above k_fast may have no inverse; use a PI")
        loop = self.model.hysteresis
        names = [*loop.values, "low", "high", "gain"]
        lanes = np.array(np.broadcast_arrays(*(v[n] for n in names))).reshape(len(names), -1)
        for lane in np.unique(lanes, axis=1).T:  # of thousands most are the same
            of = dict(zip(names, map(float, lane), strict=True))
            one = loop.from_values(of)
            problem = one.problem(of["low"] * of["gain"], of["high"] * of["gain"])
            if problem:
                raise ValueError(f"a loop without an inverse: {problem}; use a PI")

    @classmethod
    def of(cls, plant: Wrist, **settings: Number) -> Any:
        """The controller whose model is a wrist of floats, with other `settings` by their names.

        Raises InputError, in one line that names the alternative, for a wrist whose loop cannot be
        inverted and for one with effects.
        """
        refusal = no_inverse(plant)
        if refusal:
            raise InputError(refusal)
        low, high = plant.rig.command_range
        return cls(replace(plant, effects=()), **{"low": low, "high": high, **settings})

    @property
    def gain(self) -> Number:
        """The regulator's, as the model has it [kPa/V]."""
        return self.model.regulator.gain

    @property
    def settings(self) -> dict[str, Number]:
        """All settings by name, the model's by those that they have in a wrist."""
        own = {f.name: getattr(self, f.name) for f in fields(self) if f.name != "model"}
        return {**self.model.values, **own}

    def _sampled_course(self, dt: float) -> SampledReferenceModel:
        lead = self.model.Tw * self.speed - 1.0
        air = self.model.regulator
        return SampledReferenceModel(
            self.model.sampled(dt), air.k_fast, air.k_slow, self.model.Tw, lead, self.low, self.high
        )

    def sampled(self, dt: float = SAMPLE_TIME) -> Any:
        """Coefficients for a sample time `dt` [s]."""
        return SampledFeedforward(self._sampled_course(dt))

    def _begin(self, pressure: Number, seen: Measured | None) -> tuple[ReferenceModel, Number]:
        """The model at rest at what is seen, and by how much [kPa] the pressure lies beside the model's."""
        seen = Measured(0.0, 0.0, pressure) if seen is None else seen
        loop = self.model.hysteresis
        there = pressure_at_rest(seen.angle, pressure, loop)
        memory = memory_at_rest(seen.angle, there, loop)
        # At rest: a model whose angle were not its static angle would begin to move.
        return ReferenceModel(State(there, memory, memory.h), 0.0), pressure - there

    def holding(self, pressure: Number, seen: Measured | None = None) -> Any:
        """The state in which the controller holds a pressure [kPa] at the angle that is seen; its model's
        memory is that which the two tell (`controllers.memory_estimator`).

        >>> controller = Feedforward.of(Wrist.flexion())
        >>> state = controller.holding(130.0, Measured(0.0, 0.5, 130.0))      # off the loop by 11.9 kPa
        >>> round(float(state.trim), 1), round(float(controller.command(state)) * 49.4, 6)
        (11.9, 130.0)
        """
        return FeedforwardState(*self._begin(pressure, seen))

    def command(self, state: Any) -> Number:
        """The command [V] that a state gives while the model rests and is followed."""
        return (state.course.model.pressure + state.trim) / self.gain


@remembers(
    trim=("kPa", "pressure needed beside the model's to hold still at the start"),
)
class FeedforwardState(NamedTuple):
    """What the controller remembers: its model, and the pressure [kPa] that was needed beside the model's
    to hold still at the start."""

    course: ReferenceModel
    trim: Number


class SampledFeedforward(NamedTuple):
    """Coefficients of the controller for one sample time."""

    course: SampledReferenceModel

    def act(self, state: FeedforwardState, seen: Measured) -> tuple[FeedforwardState, Number]:
        """State after, and command [V] of, one sample; of what is seen the reference alone counts."""
        course, command = proceed(state.course, seen.reference, self.course)
        command = command + state.trim / self.course.wrist.regulator.gain
        command = np.minimum(np.maximum(command, self.course.low), self.course.high)
        return FeedforwardState(course, state.trim), command


@dataclass(frozen=True)
class FeedforwardPI(Feedforward):
    """A feedforward and a PI on the difference between model and wrist: Kp [kPa/deg], Ki [kPa/(deg s)].

    dead_time [s]: known dead time of the wrist; the PI sees the model delayed by it.  Angle
    and pressure are measured: they tell the memory from which the model goes to each new reference.
    Raises ValueError as `Feedforward`, and for gains or a dead time that are negative.
    """

    TUNED: ClassVar[tuple[str, ...]] = ("speed", "dead_time")

    Kp: Number = 0.0
    Ki: Number = 0.0
    dead_time: Number = 0.0

    @classmethod
    def of(cls, plant: Wrist, **settings: Number) -> Any:
        """The controller whose model is a wrist, and which knows of its dead time unless told another.

        Raises InputError as `Feedforward.of`.
        """
        return super().of(plant, **{"dead_time": dead_time_of(plant.effects), **settings})

    def __post_init__(self) -> None:
        super().__post_init__()
        if any(np.any(np.asarray(v, float) < 0.0) for v in (self.Kp, self.Ki, self.dead_time)):
            raise ValueError("gains and dead time must not be negative")

    @property
    def pi(self) -> PI:
        """The PI, whose margins are those of the loop: the feedforward stands outside of it."""
        return PI(self.Kp, self.Ki, self.gain, self.model.hysteresis.rest_pressure, self.low, self.high)

    def sampled(self, dt: float = SAMPLE_TIME) -> "SampledFeedforwardPI":
        """Coefficients for a sample time `dt` [s]."""
        return SampledFeedforwardPI(
            self._sampled_course(dt), self.Kp, self.Ki * dt, delay.sampled(self.dead_time, dt),
            MemoryObserver.of(self.model).sampled(dt),
        )  # fmt: skip

    def holding(self, pressure: Number, seen: Measured | None = None) -> "FeedforwardPIState":
        """The state in which the controller holds a pressure [kPa] at the angle that is seen."""
        course, trim = self._begin(pressure, seen)
        m = course.model
        seen = Measured(m.angle, m.angle, pressure) if seen is None else seen
        observed = ObserverState(m.memory, m.angle, seen.pressure)
        return FeedforwardPIState(course, trim, delay.at_rest(m.angle), observed, seen.reference, 1.0)


@remembers(
    trim=("kPa", "integral part of the command, gain included"),
    reference=("deg", "reference of the sample before"),
    held=("", "1 where that was the reference of the sample before it too, else 0"),
)
class FeedforwardPIState(NamedTuple):
    """What the controller remembers: its model, the integral part of its PI [kPa], called `trim` as in a
    feedforward, the angles of the model that a known dead time holds back, what it observes of the wrist, and
    the last reference [deg] with whether it was held."""

    course: ReferenceModel
    trim: Number
    late: DelayLine
    observed: ObserverState
    reference: Number
    held: Number


class SampledFeedforwardPI(NamedTuple):
    """Coefficients of the controller for one sample time."""

    course: SampledReferenceModel
    Kp: Number
    Ki_dt: Number
    delay: SampledDelay
    observer: SampledObserver

    def act(self, state: FeedforwardPIState, seen: Measured) -> tuple[FeedforwardPIState, Number]:
        """State after, and command [V] of, one sample; the integrator stands still while the command is
        clipped, unless the error drives it back, as that of `design.controllers.pi`."""
        observed = memory_estimator.step(state.observed, seen.angle, seen.pressure, self.observer)
        same = np.where(np.abs(seen.reference - state.reference) < SAME, 1.0, 0.0)
        leaves = state.held * (1.0 - same) > 0.5  # along a ramp the model goes on from itself
        before, m = state.course.model, _where(leaves, observed, state.course.model)
        trim = state.trim + (before.pressure - m.pressure)  # what holds the wrist still stays the same
        late, expected = delay.step(state.late, m.angle, self.delay)
        course, forward = proceed(state.course._replace(model=m), seen.reference, self.course)
        error = expected - seen.angle
        wanted = forward + (self.Kp * error + trim) / self.course.wrist.regulator.gain
        command = np.minimum(np.maximum(wanted, self.course.low), self.course.high)
        pushes_out = (wanted - command) * error > 0.0
        trim = trim + np.where(pushes_out, 0.0, self.Ki_dt * error)
        return FeedforwardPIState(course, trim, late, observed, seen.reference, same), command


def _where(condition: Any, observed: ObserverState, model: State) -> State:
    """The wrist as it is observed where a condition is true, else the model's."""
    there = State(observed.pressure, observed.memory, observed.angle)
    pairs = zip(pytrees.leaves(there), pytrees.leaves(model), strict=True)
    return State(*pytrees.like(model, [np.where(condition, a, b) for a, b in pairs]))
