"""Remainders made on the spot: plausible variables, noise of a known colour, and structure added to it."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy.signal import lfilter

from plants.measured.campaigns.recording import Recording
from plants.measured.residual.series.remainder import Array, Remainder, variables

DT = 0.01
RNG = np.random.Generator


def coloured(rows: int, memory: float, rng: RNG, dt: float = DT) -> Array:
    """First-order noise of variance 1 with a correlation time [s]; white for 0."""
    if memory == 0.0:
        return rng.standard_normal(rows)
    keep = np.exp(-dt / memory)
    start = [keep * rng.standard_normal()]
    return np.asarray(lfilter([np.sqrt(1.0 - keep**2)], [1.0, -keep], rng.standard_normal(rows), zi=start)[0])


def run(name: str, levels: Sequence[float], hold: float, dt: float = DT, seed: int = 0) -> Recording:
    """A recording without noise: levels [kPa] held for so long [s], followed with a lag, and with play."""
    rng = np.random.default_rng(seed)
    target = np.repeat(levels, round(hold / dt))
    time = np.arange(len(target)) * dt
    keep = np.exp(-dt / 0.4)
    pressure = np.asarray(lfilter([1.0 - keep], [1.0, -keep], target - 100.0)) + 100.0
    play = np.empty(len(pressure))
    at = 0.0
    for i, p in enumerate((pressure - 100.0).tolist()):
        at = min(max(at, p - 15.0), p + 15.0)
        play[i] = at
    knots = np.arange(0.0, time[-1] + 10.0, 5.0)
    other = np.interp(time, knots, rng.uniform(40.0, 170.0, len(knots)))
    return Recording(name, time, target / 49.4, 0.25 * play, pressure, None, other)


def recordings(dt: float = DT) -> list[Recording]:
    """Three recordings of 136, 80 and 64 s: a staircase, random steps, a random walk."""
    rng = np.random.default_rng(11)
    once = [100.0, 150.0, 197.0, 150.0, 100.0, 50.0, 0.0, 50.0]
    walk = 100.0 + np.cumsum(rng.choice([-1.0, 1.0], 32) * rng.uniform(2.0, 9.0, 32))
    return [
        run("staircase", [*once, *once, 100.0], 8.0, dt, 1),
        run("steps", rng.uniform(5.0, 190.0, 40).tolist(), 2.0, dt, 2),
        run("small", walk.tolist(), 2.0, dt, 3),
    ]


RUNS = recordings()
VARIABLES = [variables(r, r.pressure, r.angle) for r in RUNS]


def noise(seed: int, memory: float = 0.0, size: float = 1.0) -> list[Remainder]:
    """Nothing but noise of a floor and correlation time [s] in all three recordings."""
    rng = np.random.default_rng([seed, round(1000 * memory)])
    return [
        Remainder(r.name, "wrist", r.time, size * coloured(len(r.time), memory, rng), size, v)
        for r, v in zip(RUNS, VARIABLES, strict=True)
    ]


def with_structure(
    remainders: Sequence[Remainder], change: Callable[[Remainder, RNG], Array], seed: int = 0
) -> list[Remainder]:
    """The remainders with values that a function of each, and of a generator, makes of them."""
    rng = np.random.default_rng([seed, 99])
    return [replace(r, value=change(r, rng)) for r in remainders]


def short(memory: float = 0.1, rows: Sequence[int] = (900, 700)) -> list[Remainder]:
    """Two short recordings with one variable."""
    rng = np.random.default_rng(1)
    return [
        Remainder(
            str(n), "wrist", np.arange(n) * DT, coloured(n, memory, rng), 1.0,
            {"x": np.sin(np.arange(n) / 150.0)},
        )
        for n in rows
    ]  # fmt: skip
