"""Recordings that would tell two models apart, found by simulating both."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from plants.equilibrium import holding_command
from plants.simulation.open_loop import open_loop
from plants.wrist import Wrist

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Experiment:
    """A recording to make: name, why it shows what others do not, command [V] of every sample, and the
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


def experiments(wrist: Wrist) -> tuple[Experiment, ...]:
    """The recordings to choose from, about the command that holds the wrist at its rest pressure."""
    (low, high), dt = wrist.rig.command_range, wrist.rig.sample_time
    still = wrist.hysteresis.rest_pressure
    rest = float(holding_command(wrist, still))
    span = min(rest - low, high - rest) * 0.95
    swing = 0.3 * (wrist.rig.pressure_range[1] - wrist.rig.pressure_range[0])

    def made(name: str, shows: str, duration: float, wave: Callable[[Array], Array]) -> Experiment:
        time = np.asarray(np.arange(round(duration / dt)) * dt, float)
        return Experiment(name, shows, rest + span * wave(time), np.full(len(time), still))

    shows = "the other motion moved over its range, this one held"
    other = made("other motion alone", shows, 40.0, np.zeros_like)
    waves = still + swing * _triangle(np.arange(len(other.command), dtype=float) * (dt / 20.0))
    return (
        made("slow triangle", "the branches over the whole range, nothing fast", 80.0,
             lambda t: _triangle(t / 40.0)),
        made("nested minor loops", "reversals of falling size around one point", 90.0, _loops),
        made("long hold", "what goes on while nothing is moved", 120.0,
             lambda t: 0.5 * (t > 2.0).astype(float)),
        made("frequency sweep", "fast motion, from 0.05 to 3 Hz", 60.0, lambda t: 0.4 * _sweep(t)),
        replace(other, other_pressure=waves),
    )  # fmt: skip


def separate(one: Wrist, other: Wrist, channel: str, noise: float) -> Separation:
    """The experiment in which two wrists lie furthest apart in a channel."""
    found, every = [], round(one.rig.log_time / one.rig.sample_time)
    for experiment in experiments(one):
        sides = [
            open_loop(w, experiment.command, every=every, other_pressure=experiment.other_pressure)
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
