"""Recordings that would tell two models apart, found by simulating both."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plants.simulation.open_loop import open_loop
from plants.wrist import COMMAND_RANGE, SAMPLE_TIME, Wrist

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Experiment:
    """A recording to make: name, why it shows what others do not, command [V] of every ms, and the
    pressure of the other motion [kPa]."""

    name: str
    shows: str
    command: Array
    other_pressure: Array


@dataclass(frozen=True)
class Separation:
    """How far two models lie apart in an experiment: root mean square difference over the noise."""

    experiment: Experiment
    ratio: float


def experiments(rest: float) -> tuple[Experiment, ...]:
    """The recordings to choose from; `rest` [V] holds the wrist at its rest pressure."""
    span = min(rest - COMMAND_RANGE[0], COMMAND_RANGE[1] - rest) * 0.95
    still = 100.0
    return (
        Experiment("slow triangle", "the branches over the whole range, nothing fast",
                   rest + span * _triangle(_time(80.0) / 40.0), np.full(80_000, still)),
        Experiment("nested minor loops", "reversals of falling size around one point",
                   rest + span * _loops(_time(90.0)), np.full(90_000, still)),
        Experiment("long hold", "what goes on while nothing is moved",
                   rest + 0.5 * span * (_time(120.0) > 2.0).astype(float), np.full(120_000, still)),
        Experiment("frequency sweep", "fast motion, from 0.05 to 3 Hz",
                   rest + 0.4 * span * _sweep(_time(60.0)), np.full(60_000, still)),
        Experiment("other motion alone", "the other motion moved over its range, this one held",
                   np.full(40_000, rest), still + 60.0 * _triangle(_time(40.0) / 20.0)),
    )  # fmt: skip


def separate(one: Wrist, other: Wrist, channel: str, noise: float) -> Separation:
    """The experiment in which two wrists lie furthest apart in a channel."""
    rest = one.hysteresis.rest_pressure / one.regulator.gain
    found = []
    for experiment in experiments(rest):
        sides = [
            open_loop(w, experiment.command, every=10, other_pressure=experiment.other_pressure)
            for w in (one, other)
        ]
        a, b = (s.pressure if channel == "pressure_kPa" else s.angle for s in sides)
        found.append(Separation(experiment, float(np.sqrt(np.mean((a - b) ** 2))) / noise))
    return max(found, key=lambda s: s.ratio)


def sentence(name: str, other: str, found: Separation) -> str:
    """In words, what would tell two effects apart."""
    if found.ratio < 1.0:
        return f"{name} and {other}: no recording tried here would tell them apart beyond the noise"
    return (
        f"{name} or {other}: record a {found.experiment.name} ({found.experiment.shows}); "
        f"the two models differ there by {found.ratio:.2g} times the noise"
    )


def _time(duration: float) -> Array:
    return np.asarray(np.arange(round(duration / SAMPLE_TIME)) * SAMPLE_TIME, float)


def _triangle(phase: Array) -> Array:
    """Triangle wave of period 1 that starts at 0, rises to 1 and falls to -1."""
    wave: Array = 2.0 / np.pi * np.arcsin(np.sin(2.0 * np.pi * phase))
    return wave


def _loops(time: Array) -> Array:
    """Slow triangle periods of 15 s whose size falls from one to the next."""
    sizes = np.array([1.0, 0.8, 0.6, 0.4, 0.25, 0.15])
    wave: Array = sizes[np.minimum(time // 15.0, 5).astype(int)] * _triangle(time / 15.0)
    return wave


def _sweep(time: Array) -> Array:
    """Logarithmic sweep from 0.05 to 3 Hz."""
    rate = np.log(3.0 / 0.05) / time[-1]
    wave: Array = np.sin(2.0 * np.pi * 0.05 * (np.exp(rate * time) - 1.0) / rate)
    return wave
