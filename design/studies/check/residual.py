"""What the traced plant leaves of a log of the closed loop: as much as it left before, or something new.

The plant runs freely from the logged command.  How much it may leave is what its residual and noise were,
and what plants of its box differ by under the same command; a load or a dead time that the design allows
for, but the plant did not have, is new.  What is new is tried against changes that rigs go through, each of
one parameter, on a grid: a hint of where to look, no identification.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from design.robustness.box import Box
from design.robustness.samples.draws import CASES, generator
from plants.measured.campaigns.begin import Begin, first_begin, measured
from plants.measured.campaigns.playback import Playback
from plants.measured.fitting.stage import begun
from plants.measured.residual.stillness import noise_of_campaign
from plants.parameters.remainder import CHANNELS
from plants.simulation.disturbance import burdened
from plants.wrist import Wrist

Array = NDArray[np.float64]
MARGIN = 1.3
"""A residual is new above this many times the largest that the plants of the box would leave."""

STRETCH = 1.5
"""Factor of a residual that may be left of another log: what a model leaves depends on what is asked."""

PLANTS = 64
"""Plants of the box that are run from the logged command."""

POINTS = 41
"""Sizes that each change is tried at."""

TAKES = 0.5
"""A change is told where it takes away this share of what is new."""


@dataclass(frozen=True)
class ChannelResidual:
    """A channel of a log beside the traced plant, in its unit: what it leaves (n,), rms, what it left before,
    noise included, None where the plant does not say, and the rms up to which it is the one that was left."""

    channel: str
    left: Array
    rms: float
    before: float | None
    allowed: float

    @property
    def new(self) -> bool:
        """Whether more is left than the plant explains."""
        return self.rms > self.allowed


@dataclass(frozen=True)
class RigChange:
    """A change that rigs go through: in words, its size and unit, the share of what is new that it takes
    away."""

    name: str
    size: float
    unit: str
    takes: float


@dataclass(frozen=True)
class ResidualCheck:
    """The channels that were logged, and the change that goes with what is new, None where nothing is new or
    none goes with it."""

    channels: tuple[ChannelResidual, ...]
    change: RigChange | None

    @property
    def new(self) -> bool:
        """Whether a channel leaves something new."""
        return any(c.new for c in self.channels)

    def known(self, channel: str) -> float:
        """What a model is known to leave of a channel, rms in its unit: what this log leaves, and no more
        than what the recordings that it was traced on did."""
        return next((min(c.rms, c.before or 0.0) for c in self.channels if c.channel == channel), 0.0)


def residual(playback: Playback, box: Box, seed: int) -> ResidualCheck:
    """Hold a log against free runs of a plant, from the logged command; what is new is tried against the
    changes of rigs."""
    channels, wrist = channel_residuals(playback, box, drawn(box, seed)), box.wrist
    begin = first_begin(playback.recording, float(wrist.hysteresis.rest_pressure), wrist.rig)
    new = any(c.new for c in channels)
    return ResidualCheck(channels, _change(playback, wrist, begin, channels) if new else None)


def drawn(box: Box, seed: int) -> Array:
    """Places in a box (intervals, PLANTS), as `design.robustness.box.Box.at` takes them."""
    return generator(seed, 0, CASES).random((len(box.intervals), PLANTS))


def channel_residuals(playback: Playback, box: Box, shares: Array) -> tuple[ChannelResidual, ...]:
    """The channels of a log beside free runs of a plant, from the logged command; shares: places of other
    plants in its box, (intervals, lanes)."""
    wrist, log = box.wrist, playback.recording
    begin = first_begin(log, float(wrist.hysteresis.rest_pressure), wrist.rig)
    nominal = free_readings(playback, wrist, begin)
    others = free_readings(playback, box.at(shares), begin) if box.intervals else nominal
    found = []
    for i, channel in enumerate(CHANNELS):
        truth, kept = measured(log, channel), box.plant.remainder.get(channel)
        if truth is None:
            continue
        left = truth - nominal[i][:, 0]
        noise = noise_of_campaign([log], channel) or 0.0
        before = noise if kept is None else float(np.hypot(kept.rms, noise))
        stretched = STRETCH * (0.0 if kept is None else kept.rms)
        spread = np.mean((others[i] - nominal[i]) ** 2, axis=0)
        allowed = MARGIN * float(np.sqrt(noise**2 + stretched**2 + spread.max()))
        rms = float(np.sqrt(np.mean(left**2)))
        found.append(ChannelResidual(channel, left, rms, None if kept is None else before, allowed))
    return tuple(found)


def free_readings(playback: Playback, wrist: Wrist, begin: Begin) -> tuple[Array, Array]:
    """Readings of angle [deg] and pressure [kPa] of wrists at a log's rows, from its command, (n, lanes)."""
    pressure, angle = playback.play(wrist, begun(wrist, None if begin.at_zero else begin))
    return tuple(np.reshape(x, (len(playback.rows), -1)) for x in (angle, pressure))  # type: ignore[return-value]


def _change(
    playback: Playback, wrist: Wrist, begin: Begin, channels: tuple[ChannelResidual, ...]
) -> RigChange | None:
    """The change that takes most of what is new, if it takes enough of it."""
    best: RigChange | None = None
    noise = {c.channel: c.allowed / MARGIN for c in channels}

    def off(runs: tuple[Array, Array]) -> Array:
        simulated = dict(zip(CHANNELS, runs, strict=True))
        parts = []
        for c in channels:
            truth = measured(playback.recording, c.channel)
            assert truth is not None
            parts.append(
                np.mean((truth[:, None] - simulated[c.channel]) ** 2, axis=0) / noise[c.channel] ** 2
            )
        return np.asarray(np.sum(parts, axis=0), float)

    excess = sum((c.rms / noise[c.channel]) ** 2 - 1.0 for c in channels)
    for name, unit, sizes, changed in _changes(wrist):
        chi2 = off(free_readings(playback, changed(sizes), begin)) - len(channels)
        k = int(np.argmin(chi2))
        takes = float(1.0 - max(chi2[k], 0.0) / max(excess, 1e-9))
        if best is None or takes > best.takes:
            best = RigChange(name, float(sizes[k]), unit, takes)
    return best if best is not None and best.takes >= TAKES else None


Changed = Callable[[Array], Wrist]


def _changes(wrist: Wrist) -> list[tuple[str, str, Array, Changed]]:
    """Changes that rigs go through: in words, unit, sizes to try, and the wrists with them as lanes."""
    roles = wrist.hysteresis.roles(wrist.hysteresis.values)
    values, factor = wrist.values, np.linspace(0.6, 1.4, POINTS)

    def scaled(*names: str) -> Changed:
        return lambda by: wrist.with_values(**{n: values[n] * by for n in names})

    found: list[tuple[str, str, Array, Changed]] = [
        ("the slopes of the loop are another, by a factor of", "1", factor,
         scaled(*roles["outer"], *roles["inner"])),
        ("the loop is wider or narrower, by a factor of", "1", factor, scaled(*roles["width"])),
        ("less pressure than commanded (a leak, a low supply), by a factor of", "1",
         np.linspace(0.8, 1.0, POINTS), scaled("gain")),
        ("the regulator is faster or slower, by a factor of", "1", np.linspace(0.4, 1.6, POINTS),
         scaled("k_fast", "k_slow")),
        ("the joint is slower or faster, by a factor of", "1", np.linspace(0.4, 2.0, POINTS), scaled("Tw")),
        ("the command arrives later by", "s", np.linspace(0.0, 0.2, POINTS),
         lambda late: burdened(wrist, late, None)),
    ]  # fmt: skip
    if "load-step" not in {e.NAME for e in wrist.effects}:
        found.append(
            (
                "a load shifts the angle by",
                "deg",
                np.linspace(-8.0, 8.0, POINTS),
                lambda by: burdened(wrist, None, by),
            )
        )
    return found
