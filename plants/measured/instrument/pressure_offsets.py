"""Pressures that are counted from another zero in each recording, as the pressure of the air changes from day
to day.

Under one command, long after it came, a regulator holds one pressure, or a vented chamber that of the air:
what a sensor shows there in one recording and not in others is its offset, if it is there in all that follows
too.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plants.measured.campaigns.begin import rows_before_move
from plants.measured.campaigns.campaign import Campaign
from plants.measured.campaigns.recording import Recording
from plants.measured.fitting.noise import noise_floor, resolution
from plants.measured.guess.rough_models import extent, first_order, lagged, recorded

Array = NDArray[np.float64]

RESTS, FEWEST = 0.5, 10
"""Time [s] and rows for which command and pressure have to stand still at the beginning."""

SAME = 0.005
"""Share of the command's range within which recordings begin at one command."""

LOUD, WORTH = 5.0, 0.003
"""Times its standard error, and share of the pressure's range, that an offset has to be."""

STAYS = 0.5
"""Share of the square of the offsets that has to be gone, once they are taken off, from what a rough model of
the regulator leaves of the pressure after the rests."""

DEGREE = 3
"""Of the curve of the pressure over the command, behind a lag."""


@dataclass(frozen=True)
class _Rest:
    """The pressure at the beginning of a recording, its standard error [kPa], and the rows."""

    pressure: float
    error: float
    rows: int


def pressure_offsets(campaign: Campaign) -> dict[str, float]:
    """Offset of the pressure [kPa] of each recording that begins at rest, by name, about their mean; empty
    where there are none for certain, and where they do not begin under one command."""
    low, high = extent([r.command for r in campaign.recordings])
    still = SAME * (high - low)
    found = [(r, rest) for r in campaign.recordings if (rest := _rest(r, still)) is not None]
    if len(found) < 2 or np.ptp([r.command[0] for r, _ in found]) > still:
        return {}
    runs, rests = [r for r, _ in found], [rest for _, rest in found]
    read = np.array([rest.pressure for rest in rests])
    offsets = read - read.mean()
    span = float(np.ptp(extent([v for _, v, _ in recorded(runs, "pressure")])))
    least = np.maximum([LOUD * rest.error for rest in rests], WORTH * span)
    if not np.any(np.abs(offsets) > least) or not _stay(runs, rests, offsets):
        return {}
    return {r.name: float(v) for r, v in zip(runs, offsets, strict=True)}


def _rest(run: Recording, still: float) -> _Rest | None:
    """Where a recording stands still at its beginning; None where it does not for long enough, and where
    its command never moves or its pressure was not logged."""
    if run.pressure is None:
        return None
    rows = rows_before_move(run, still)
    if rows < FEWEST or rows == len(run.time) or run.time[rows - 1] - run.time[0] < RESTS:
        return None
    shown = run.pressure[:rows]
    halves = np.array_split(shown, 2)
    noise = max(noise_floor(run.pressure), resolution(run.pressure), float(np.std(shown)))
    error = noise / rows**0.5
    drifts = abs(float(halves[0].mean() - halves[1].mean())) > LOUD * error
    return None if drifts else _Rest(float(shown.mean()), error, rows)


def _stay(runs: Sequence[Recording], rests: Sequence[_Rest], offsets: Array) -> bool:
    """Whether a rough model of the regulator leaves as much less of what follows the rests, once the offsets
    are taken off, as offsets that stay would make it."""
    logged = recorded(runs, "pressure")
    follows = first_order(logged)
    shapes, pressures, own = [], [], []
    for (command, pressure, dt), rest, off in zip(logged, rests, offsets, strict=True):
        shape = lagged(np.minimum(command, follows.most), dt, follows.tau, follows.delay)
        shapes.append(shape[rest.rows :])
        pressures.append(pressure[rest.rows :])
        own.append(np.full(len(pressure) - rest.rows, off))
    x, y, off = (np.concatenate(parts) for parts in (shapes, pressures, own))
    if np.ptp(x) == 0.0:
        return False
    columns = np.polynomial.chebyshev.chebvander((x - x.min()) / np.ptp(x), DEGREE)
    basis, _ = np.linalg.qr(columns)
    # What such a curve takes up of the offsets, where a recording asks for other pressures, does not count.
    left, without, apart = (float(np.mean((v - basis @ (basis.T @ v)) ** 2)) for v in (y, y - off, off))
    return left - without > STAYS * apart > 0.0
