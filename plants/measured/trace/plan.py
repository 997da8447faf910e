"""The next recording: of many commands, the one after which least is open.

Where effects tie, that in which their models lie furthest apart, the tied one having refitted its parameters
as far as the campaign lets it (T-optimal design, Atkinson and Fedorov, The design of experiments for
discriminating between two rival models, Biometrika 62, 1975, doi 10.1093/biomet/62.1.57, with the campaign's
information as prior); the worst pair counts.  Where nothing ties, that which shrinks the region of confidence
of the parameters most (D-optimal).  Commands are parts of steps, reversals, waves, holds and stairs, drawn
with a seed; the best is changed part by part where that helps.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plants.measured.trace.judge import alternatives
from plants.measured.trace.result import Trace
from plants.measured.trace.stages.model import Model
from plants.rig import Rig
from plants.simulation.open_loop import open_loop
from plants.wrist import Wrist

Array = NDArray[np.float64]
WITHIN = 0.95
"""Share of the way from rest to the ends of the command's range that is used."""

CALM = 1.0
"""Time [s] at rest at the start: a recording begins there."""

PARTS = 3
"""Parts of a command, each of a kind of its own."""

SHARE_OF_ERROR = 0.1
"""By what share of its standard error a parameter is moved for a derivative."""

Kind = Callable[[Array, np.random.Generator], Array]


@dataclass(frozen=True)
class Rival:
    """Two models of which a campaign cannot tell which is the rig's: the effects' names, the wrists, channel
    and its noise; of the second what is fitted, by name, and the campaign's information about it (n, n)."""

    name: str
    other: str
    one: Wrist
    two: Wrist
    channel: str
    noise: float
    names: tuple[str, ...]
    information: Array


@dataclass(frozen=True)
class PlannedRecording:
    """A recording to make: command [V] of every sample, and what it is predicted to tell.

    rivals: the ties; planned, staircase: of each pair the distance [noise] at which the second model is left
    in it and in a staircase of the same length; gain, staircase_gain: by what factor the standard errors
    shrink, their geometric mean; candidates: commands that were tried; rig: that they are for.
    """

    command: Array
    staircase: Array
    rivals: tuple[Rival, ...]
    planned: tuple[float, ...]
    staircase_distance: tuple[float, ...]
    gain: float
    staircase_gain: float
    candidates: int
    rig: Rig


def chance(distance: float) -> float:
    """Chance of naming the wrong of two models that lie a distance [noise] apart.

    >>> round(chance(0.0), 2), round(chance(4.0), 3)
    (0.5, 0.023)
    """
    from scipy.special import ndtr

    return float(ndtr(-0.5 * distance))


def rivals_of(trace: Trace) -> tuple[Rival, ...]:
    """The pairs of models that a trace could not tell apart."""
    found = []
    for stage in trace.stages:
        for name, candidates in alternatives(stage.search).items():
            for c in candidates:
                other = next(iter(set(c.model.effects) - set(stage.model.effects)))
                found.append(rival(stage.model, c.model, name, other))
    return tuple(found)


def rival(one: Model, two: Model, name: str, other: str) -> Rival:
    """Two models of a stage as rivals."""
    _, slopes = two.linear
    stage = one.stage
    return Rival(name, other, one.wrist, two.wrist, stage.channel, stage.noise, two.names, slopes.T @ slopes)


def plan(
    rivals: Sequence[Rival], own: Sequence[Rival], seconds: float = 60.0, seed: int = 0, tried: int = 24
) -> PlannedRecording:
    """The best recording of a length [s] of those tried; `own`: of each stage the model that was chosen, as
    its own rival, for the parameters.

    Raises ValueError where there is neither.
    """
    if not own and not rivals:
        raise ValueError("a plan needs a model")
    wrist = (*rivals, *own)[0].one
    dt, rng = wrist.rig.sample_time, np.random.default_rng(seed)
    time = np.asarray(np.arange(round(seconds / dt)) * dt, float)

    def worth(command: Array) -> float:
        if rivals:
            return min(distance(r, command) for r in rivals)
        return shrinks(own, command)

    kinds = list(KINDS.values())
    draws = [
        [(kinds[(i + k) % len(kinds)], int(rng.integers(2**31))) for k in range(PARTS)] for i in range(tried)
    ]
    values = [worth(made(wrist, time, d)) for d in draws]
    best = int(np.argmax(values))
    chosen, value, count = draws[best], values[best], tried
    for part in range(PARTS):
        for kind in kinds:
            other = [*chosen[:part], (kind, int(rng.integers(2**31))), *chosen[part + 1 :]]
            found = worth(made(wrist, time, other))
            count += 1
            if found > value:
                chosen, value = other, found
    command, stairs = made(wrist, time, chosen), staircase(wrist, time)
    if worth(stairs) > value:
        command = stairs
    return PlannedRecording(
        command, stairs, tuple(rivals), tuple(distance(r, command) for r in rivals),
        tuple(distance(r, stairs) for r in rivals), shrinks(own, command), shrinks(own, stairs), count,
        wrist.rig,
    )  # fmt: skip


def distance(r: Rival, command: Array) -> float:
    """How far [noise] the second model stays from the first under commands [V], refitted as far as the
    campaign's information lets it."""
    apart, slopes = _answers(r, command)
    pull = slopes.T @ apart
    moved = np.linalg.solve(_regular(r.information + slopes.T @ slopes), pull)
    return float(np.sqrt(max(float(apart @ apart - pull @ moved), 0.0)))


def shrinks(own: Sequence[Rival], command: Array) -> float:
    """By what factor the standard errors of all models' parameters shrink under commands [V], their geometric
    mean [1]."""
    total, count = 0.0, 0
    for r in own:
        _, slopes = _answers(r, command)
        before = np.linalg.slogdet(_regular(r.information))[1]
        total += np.linalg.slogdet(_regular(r.information + slopes.T @ slopes))[1] - before
        count += len(r.names)
    return float(np.exp(0.5 * total / count)) if count else 1.0


def _regular(information: Array) -> Array:
    """A matrix that has an inverse: what nothing is known of is known to next to nothing."""
    return np.asarray(information + np.diag(1e-9 * np.diag(information) + 1e-12), float)


def _answers(r: Rival, command: Array) -> tuple[Array, Array]:
    """The difference of the models at the rows of a log, (rows,), and the second's derivatives, (rows, n), in
    units of the noise."""
    sizes = SHARE_OF_ERROR / np.sqrt(np.maximum(np.diag(r.information), 1e-12))
    base = r.two.values
    sizes = np.minimum(sizes, 0.01 * np.maximum(np.abs([base[n] for n in r.names]), 1e-3))
    lanes = {n: np.full(len(r.names) + 1, v, float) for n, v in base.items()}
    for i, n in enumerate(r.names):
        lanes[n][i + 1] += sizes[i]
    one = _logged(r.one, command, r.channel)[:, 0]
    two = _logged(r.two.made_of(lanes), command, r.channel)
    return (two[:, 0] - one) / r.noise, (two[:, 1:] - two[:, :1]) / (sizes * r.noise)


def _logged(wrist: Wrist, command: Array, channel: str) -> Array:
    """A channel at the rows of a log, (rows, lanes)."""
    response = open_loop(wrist, command, every=round(wrist.rig.log_time / wrist.rig.sample_time))
    values = response.pressure if channel == "pressure_kPa" else response.angle
    return np.asarray(np.reshape(values, (len(values), -1)), float)


def _steps(t: Array, rng: np.random.Generator) -> Array:
    """Random levels, each held for 0.6 to 4 s."""
    edges = np.cumsum(rng.uniform(0.6, 4.0, int(t[-1] / 0.6) + 2))
    return np.asarray(rng.uniform(-1.0, 1.0, edges.size + 1)[np.searchsorted(edges, t)], float)


def _reversals(t: Array, rng: np.random.Generator) -> Array:
    """Ramps between random turning points, 1 to 6 s each."""
    edges = np.append(0.0, np.cumsum(rng.uniform(1.0, 6.0, int(t[-1]) + 2)))
    levels = np.append(0.0, rng.uniform(-1.0, 1.0, edges.size - 1))
    return np.asarray(np.interp(t, edges, levels), float)


def _waves(t: Array, rng: np.random.Generator) -> Array:
    """Sines of random phases, 0.05 to 3 Hz."""
    rates = np.geomspace(0.05, 3.0, 12)
    sum_ = np.sin(2.0 * np.pi * rates * t[:, None] + rng.uniform(0.0, 2.0 * np.pi, 12)) @ (rates**-0.3)
    return np.asarray((sum_ - sum_[0]) / np.abs(sum_ - sum_[0]).max(), float)


def _holds(t: Array, rng: np.random.Generator) -> Array:
    """Two far levels, each held for long."""
    level = rng.choice([-1.0, 1.0]) * rng.uniform(0.5, 1.0, 2) * np.array([1.0, -1.0])
    return np.asarray(np.where(t < t[-1] * rng.uniform(0.3, 0.7), level[0], level[1]), float)


def _stairs(t: Array, rng: np.random.Generator) -> Array:
    """Even stairs once around the loop."""
    levels = rng.choice([-1.0, 1.0]) * np.array([0.5, 1.0, 0.5, 0.0, -0.5, -1.0, -0.5, 0.0])
    return np.asarray(levels[np.minimum((t * levels.size / t[-1]).astype(int), levels.size - 1)], float)


KINDS: dict[str, Kind] = {
    "steps": _steps,
    "reversals": _reversals,
    "waves": _waves,
    "holds": _holds,
    "stairs": _stairs,
}
"""Kinds of parts: of times from 0 [s], a wave within -1 to 1."""


def made(wrist: Wrist, time: Array, parts: Sequence[tuple[Kind, int]]) -> Array:
    """The command [V] of parts, each a kind and its seed, after a calm start."""
    rest, span = _range(wrist)
    begins = np.linspace(CALM, time[-1] + (time[1] - time[0]), len(parts) + 1)
    wave = np.zeros(time.size)
    for (kind, seed), begin, end in zip(parts, begins[:-1], begins[1:], strict=True):
        here = (time >= begin) & (time < end)
        wave[here] = kind(time[here] - time[here][0], np.random.default_rng(seed))
    every = round(wrist.rig.log_time / wrist.rig.sample_time)
    wave = np.repeat(wave[::every], every)[: time.size]  # a logger writes a command a row
    return np.asarray(rest + np.where(wave > 0.0, span[1], span[0]) * wave, float)


def staircase(wrist: Wrist, time: Array) -> Array:
    """Once around the loop in eight even steps: what a plan is held against."""
    rest, span = _range(wrist)
    levels = np.array([0.0, 0.5, 1.0, 0.5, 0.0, -0.5, -1.0, -0.5, 0.0])
    wave = levels[np.minimum((time * levels.size / time[-1]).astype(int), levels.size - 1)]
    return np.asarray(rest + np.where(wave > 0.0, span[1], span[0]) * wave, float)


def _range(wrist: Wrist) -> tuple[float, tuple[float, float]]:
    """The command [V] that holds the wrist at rest, and how far it may go down and up from there."""
    low, high = wrist.rig.command_range
    rest = float(wrist.hysteresis.rest_pressure / wrist.regulator.gain)
    return rest, (WITHIN * (rest - low), WITHIN * (high - rest))
