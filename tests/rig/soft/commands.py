"""Commands at 1 kHz: a sine, stairs, levels at random."""

from collections.abc import Sequence

import numpy as np

from tests.rig.signals import Signal
from tests.rig.soft.chain import TICK


def sine(low: float, high: float, frequency: float, seconds: float) -> Signal:
    """Between two commands, from the lower one."""
    t = np.arange(round(seconds / TICK)) * TICK
    return 0.5 * (low + high) - 0.5 * (high - low) * np.cos(2.0 * np.pi * frequency * t)


def stairs(levels: Sequence[float], hold: float) -> Signal:
    """Levels held for a time [s]."""
    return np.repeat(np.asarray(levels, float), round(hold / TICK))


def wandering(low: float, high: float, hold: float, seconds: float, seed: int) -> Signal:
    """Random levels, each held from half to one and a half times `hold` [s]."""
    rng, parts, total = np.random.default_rng(seed), [np.full(1000, low)], 1.0
    while total < seconds:
        for_s = rng.uniform(0.5, 1.5) * hold
        parts.append(np.full(round(for_s / TICK), rng.uniform(low, high)))
        total += for_s
    return np.concatenate(parts)[: round(seconds / TICK)]
