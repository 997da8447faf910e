"""Angles that are counted from another zero in each recording, where recordings start anywhere.

A first guess of the loop is fitted to all recordings with a constant of its own for each.  A constant is
taken for the sensor's offset only if the first rows of the recordings say the same: then it can be told of a
recording that was held out, too, from where it begins.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from plants.measured.campaign import Campaign
from plants.measured.guess.rough_models import LoopGuess, lagged, loop_guess, static_guess
from plants.measured.recording import Recording

Array = NDArray[np.float64]
ROUNDS = 4
"""How often loop and constants are found in turn."""

BETTER = 0.7
"""Share of the error that constants must leave, at most, of what is left without them."""

AGREE = 0.35
"""Spread of what recordings' first rows say less their constants, over the spread of the constants."""


def offsets_between(campaign: Campaign) -> dict[str, float]:
    """Offset of the angle [deg] of each recording, by name, about their median; empty where there are none
    for certain."""
    runs = [r for r in campaign.fit if r.pressure is not None and r.angle is not None]
    if len(runs) < 3 or any(len(r.time) < 50 for r in runs):
        return {}
    plain = loop_guess(runs, _drives(runs))
    at = dict.fromkeys((r.name for r in runs), 0.0)
    loop = plain
    for _ in range(ROUNDS):
        loop = loop_guess([_less(r, at[r.name]) for r in runs], _drives(runs))
        at = {r.name: float(np.mean(_over(loop, r))) for r in runs}
        middle = float(np.median(list(at.values())))
        at = {n: v - middle for n, v in at.items()}
    loop = loop_guess([_less(r, at[r.name]) for r in runs], _drives(runs))
    spread = float(np.std(list(at.values())))
    first = [float(np.median(_over(loop, r)[:3])) - at[r.name] for r in runs]
    if loop.rms > BETTER * plain.rms or float(np.std(first)) > AGREE * spread:
        return {}
    begin = float(np.median(first))
    for r in campaign.validate:
        if r.pressure is not None and r.angle is not None:
            at[r.name] = float(np.median(_over(loop, r)[:3])) - begin
    return at


def _drives(runs: Sequence[Recording]) -> list[Array]:
    return [r.pressure for r in runs if r.pressure is not None]


def _less(r: Recording, offset: float) -> Recording:
    assert r.angle is not None
    return replace(r, angle=r.angle - offset)


def _over(loop: LoopGuess, r: Recording) -> Array:
    """By how much the angle of a recording lies above what a loop makes of its pressure [deg]."""
    assert r.angle is not None
    (static,) = static_guess(loop, _drives([r]))
    dt = float(np.median(np.diff(r.time)))
    over: Array = r.angle - lagged(static, dt, loop.lag, 0.0) + loop.outer * loop.rest
    return over
