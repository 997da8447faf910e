"""Soft actuators drawn at random: the chain of `tests.rig.soft.rig` with other parameters and recordings."""

from dataclasses import replace

import numpy as np

from tests.rig.soft.chain import Relays
from tests.rig.soft.commands import sine, stairs, wandering
from tests.rig.soft.rig import Logger, SoftRig

RANGES = ((0.0, 5.0), (0.0, 10.0), (4.0, 20.0), (0.0, 4095.0))
"""Least and largest command: volts, milliamperes, counts."""


def soft_actuator(seed: int) -> SoftRig:
    """The actuator of a seed, with the recordings `stairs`, `wave` and `steps`, of which some are
    drawn to fit on (`recordings`), and the held-out `check`."""
    rng = np.random.default_rng([seed, 31])

    def between(low: float, high: float) -> float:
        """Drawn evenly on a logarithmic scale."""
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    low, high = RANGES[int(rng.integers(len(RANGES)))]
    most, bend = between(60.0, 400.0), between(8.0, 80.0)
    gain = most / (high - low)
    bias = rng.uniform(-0.02, 0.05) * most - gain * low
    plays = int(rng.integers(2, 6))
    widths = np.concatenate([[0.0], np.sort(rng.uniform(0.02, 0.25, plays - 1))]) * most
    weights = rng.uniform(0.3, 1.0, plays)
    weights *= bend / (weights.sum() * 0.8 * most)
    fill = between(1.0, 12.0)
    logger = Logger(
        0.001 * round(between(5.0, 50.0)),
        jitter=0.001 * int(rng.integers(0, 3)),
        renewal=float(rng.choice((0.0, 0.0, between(0.06, 0.25)))),
        angle_step=float(rng.choice((0.001, 0.002))) * bend,
        pressure_step=float(rng.choice((1e-4, 1e-3))) * most,
        angle_noise=between(3e-4, 3e-3) * bend,
        pressure_noise=between(3e-4, 3e-3) * most,
        offset=float(rng.choice((0.0, 0.01))) * bend,
        rests=bool(rng.random() < 0.25),
    )
    stops = float(rng.choice((0.0, rng.uniform(0.03, 0.1)))) * bend
    top, hold, period = low + rng.uniform(0.8, 1.0) * (high - low), between(2.0, 8.0), between(8.0, 30.0)
    levels = [low + s * (top - low) for s in (0, 0.25, 0.5, 0.75, 1, 0.6, 0.3, 0.8, 0.4, 0)]
    return SoftRig(
        f"soft{seed}", low, high, gain, bias, rng.uniform(0.0, 0.4), fill, fill * rng.uniform(0.4, 1.0),
        rng.uniform(0.0, 0.8), tuple(map(float, widths)), tuple(map(float, weights)),
        rng.uniform(0.0, 0.12) * most, rng.uniform(0.0, 0.15), bend, stops,
        (rng.uniform(0.0, 0.1), between(3.0, 20.0)), between(0.03, 0.25), logger,
        {
            "stairs": lambda: stairs(levels, hold),
            "wave": lambda: sine(low, top, 1.0 / period, 3.0 * period),
            "steps": lambda: wandering(low, top, hold, 60.0, seed),
            "check": lambda: wandering(low, top, 0.8 * hold, 60.0, seed + 5000),
        },
    )  # fmt: skip


GRID = 70
"""Switching pressures of a Preisach operator."""


def preisach_actuator(seed: int, copies: int = 8) -> SoftRig:
    """The actuator of a seed with another joint: a Preisach operator, which no set of plays is, and a mass
    that swings, in place of plays and a lag.  copies: how often each relay is drawn, a little off its place:
    the fewer, the rougher the joint moves."""
    rig, rng = soft_actuator(seed), np.random.default_rng([seed, 33])
    most = rig.gain * (rig.high - rig.low) + max(rig.bias + rig.gain * rig.low, 0.0)
    levels = np.linspace(-0.1, 1.1, GRID)
    on, off = (g.ravel() for g in np.meshgrid(levels, levels, indexing="ij"))
    on, off = on[on >= off], off[on >= off]
    middle, half = 0.5 * (on + off), 0.5 * (on - off)
    width, centre, spread = rng.uniform(0.04, 0.12), rng.uniform(0.3, 0.7), rng.uniform(0.3, 0.6)
    density = np.exp(-0.5 * ((middle - centre) / spread) ** 2 - half / width)
    density = np.where(half > 0.0, density, density * (1.0 + 3.0 * rng.uniform(0.0, 1.0)))
    density *= 1.0 + rng.uniform(-0.6, 0.6) * middle
    on, off = (np.tile(p, copies) + rng.uniform(-0.5, 0.5, copies * on.size) / GRID for p in (on, off))
    rise = np.tile(density, copies) * rig.full / (copies * density.sum())
    relays = Relays(most * np.maximum(on, off), most * np.minimum(on, off), rise)
    swing = (float(np.exp(rng.uniform(np.log(1.0), np.log(5.0)))), rng.uniform(0.15, 0.9))
    return replace(rig, name=f"preisach{seed}", cubic=0.0, relays=relays, swing=swing)


def recordings(seed: int) -> tuple[str, ...]:
    """Which recordings of the actuator there are to fit on: one of the three is missing, or none."""
    names = ("stairs", "wave", "steps")
    absent = int(np.random.default_rng([seed, 32]).integers(4))
    return tuple(n for i, n in enumerate(names) if i != absent)
