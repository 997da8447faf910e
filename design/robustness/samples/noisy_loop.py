"""The closed loop whose sensor is noisy and shows the angle in steps: `design.loop` beside a real sensor.

The controller sees reading + noise, rounded to the sensor's quantum; the judge sees the joint.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from design import loop, metrics
from design.controllers.controller import Controller, Measured
from design.loop import Loop, SampledLoop, holding
from design.metrics import Metrics
from plants import wrist as plant
from plants.effects.effect import Around
from plants.simulate import run_lanes
from plants.wrist import SAMPLE_TIME, State, Wrist

Number = Any
Array = NDArray[np.float64]
HOLD = 10
"""Samples of 1 ms that a value of the noise is held: the sensor delivers at 100 Hz."""


class Sensor(NamedTuple):
    """Coefficients of a sensor: standard deviation of its noise and its quantum [deg], 1 / quantum."""

    noise: Number
    quantum: Number
    per_quantum: Number


class SampledNoisyLoop(NamedTuple):
    """Coefficients of the loop and of its sensor."""

    loop: SampledLoop
    sensor: Sensor


def sensor(noise: float, quantum: float) -> Sensor:
    """A sensor with noise and a quantum [deg]; a quantum of 0 is never divided by, for no law uses it."""
    return Sensor(noise, quantum, 1.0 / quantum if quantum > 0.0 else 0.0)


def rounded(angle: Number, c: Sensor) -> Number:
    """The angle [deg] in whole quanta, halves upwards.

    >>> float(rounded(0.126, sensor(0.0, 0.05)))
    0.15000000000000002
    """
    return c.quantum * np.floor(angle * c.per_quantum + 0.5)


def _reading(s: Loop, inputs: tuple[Number, ...], c: SampledNoisyLoop) -> Number:
    return plant.read(s.plant, c.loop.plant, Around(*inputs[1:]))


def _after(s: Loop, inputs: tuple[Number, ...], seen: Number, c: SampledLoop) -> Loop:
    """One sample with what the controller sees [deg]: control, judge by the true angle, move."""
    measured = Measured(c.yardstick.reference - seen, seen, s.plant.pressure)
    controller, command = c.controller.act(s.controller, measured)
    tally = metrics.update(s.tally, inputs[0], s.plant.angle, command, c.yardstick)
    return Loop(plant.step(s.plant, command, c.plant, Around(*inputs[1:])), controller, tally)


def noisy_step(s: Loop, inputs: tuple[Number, ...], c: SampledNoisyLoop) -> Loop:
    """One sample behind a noisy sensor; the last of `inputs` is its noise, of standard deviation 1."""
    *others, noise = inputs
    return _after(s, tuple(others), _reading(s, tuple(others), c) + c.sensor.noise * noise, c.loop)


def rounded_step(s: Loop, inputs: tuple[Number, ...], c: SampledNoisyLoop) -> Loop:
    """One sample behind a sensor that shows whole quanta."""
    return _after(s, inputs, rounded(_reading(s, inputs, c), c.sensor), c.loop)


def noisy_rounded_step(s: Loop, inputs: tuple[Number, ...], c: SampledNoisyLoop) -> Loop:
    """One sample behind a sensor that is noisy and shows whole quanta."""
    *others, noise = inputs
    seen = _reading(s, tuple(others), c) + c.sensor.noise * noise
    return _after(s, tuple(others), rounded(seen, c.sensor), c.loop)


def law(noisy: bool, quantised: bool) -> Callable[..., Loop]:
    """The law of one sample; chosen before it is compiled, so that what is absent costs nothing."""
    if noisy:
        return noisy_rounded_step if quantised else noisy_step
    return rounded_step if quantised else loop.step


def trees(
    wrist: Wrist, controller: Controller, reference: Number, state: State, seen_by: Sensor, perfect: bool
) -> tuple[Loop, Any]:
    """First state and coefficients of the loop, as `design.loop.run` makes them; for a perfect sensor,
    those of `design.loop.step` itself."""
    held = holding(wrist, controller, state)
    measure = metrics.yardstick(state.angle, reference)
    c = SampledLoop(wrist.sampled(), controller.sampled(), measure)
    return Loop(state, held, metrics.begin(controller.command(held))), c if perfect else SampledNoisyLoop(
        c, seen_by
    )


def run(
    wrist: Wrist,
    controller: Controller,
    reference: Number,
    state: State,
    seen_by: Sensor,
    noise: Array | None = None,
    duration: float = 10.0,
    every: int = 0,
    record: tuple[str, ...] = (),
    jobs: int | None = None,
) -> tuple[Metrics, Array]:
    """Step the reference [deg] at time 0 and run the loop behind a sensor for a duration [s].

    noise: of standard deviation 1, shape (rows, lanes), a row for every `HOLD` samples; None for a
    sensor without.  Returns metrics, leaves of shape (lanes,), of the true angle, and the signals
    named in `record`, such as ``plant.angle``, after every `every` samples.  Without noise and
    quantum it is `design.loop.run`.
    """
    samples = round(duration / SAMPLE_TIME)
    quantised = seen_by.quantum > 0.0
    perfect = noise is None and not quantised
    first, c = trees(wrist, controller, reference, state, seen_by, perfect)
    times = {"time": np.arange(samples) * SAMPLE_TIME} if wrist.effects else {}
    own = {} if noise is None else {"noise": noise}
    last, rows = run_lanes(
        law(noise is not None, quantised), first, c, samples, times, ("sample", *times, *own),
        every, record, jobs, own, HOLD,
    )  # fmt: skip
    return metrics.finish(last.tally, samples), rows
