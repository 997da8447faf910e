"""Noise of a channel where the command has long been still, whatever its colour."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from plants.measured.campaigns.recording import Recording
from plants.measured.fitting.noise import is_coloured, noise_of
from plants.measured.residual.checks.periodic import harmonic, line_in, spectrum_of
from plants.measured.residual.series.background import LONGEST_MEMORY, background, first_order, positive_parts
from plants.measured.residual.series.joined import FEWEST, Joined, join
from plants.measured.residual.series.remainder import Array, Remainder

SETTLED = 3.0
"""Time after the command moved [s] from which on the wrist counts as still."""

SHORTEST = 1.5
"""Stretches of stillness shorter than this [s] say nothing of slow noise."""

ENOUGH = 20.0
"""Stillness in all [s] that is needed to tell the colour of the noise."""

MOVED = 0.002
"""The command is still while it stays within this [V] of where it stopped, 0.1 kPa."""

BENT = 2
"""Degree of the polynomial that is taken off each stretch: creep and drift are slow."""

DISTURBED = 8.0
"""A stretch with so many times the usual variance holds an event, and is left out."""

SLOWEST = 2.0
"""Cycles in a usual stretch below which trends rule."""

KEPT = 0.97
"""Part of the row before that differences take off."""

LINES = 4
"""Most lines of a sinusoid that are taken off."""

SURE = 1e-6
"""Probability of a line in noise that has none."""


def noise_of_campaign(recordings: Sequence[Recording], channel: str) -> float | None:
    """Noise floor of a channel, by its column name, over recordings of one rig; None where it was not logged.

    Noise with a memory escapes differences, which see only what is new from row to row.
    Where the command was still for long, its spectrum is looked at instead: slow
    trends are taken off each stretch and a sinusoid off all, and what lasts longer than the
    stretches is extrapolated as first-order noise of at most 0.6 s.  That is good to about 3 % for
    correlation times of 0.05 s, 6 % for 0.2 s and 8 % for 0.5 s, with 90 s of stillness.

    The floor of white noise, `noise_of`, is kept unless the noise is coloured for certain:
    where differences over several rows are not larger than those from row to row, and where
    there is too little stillness to tell (less than 20 s, 3 s after the command
    moved).  White noise with a slow part that is smaller counts as white.
    """
    logged = [(r, v) for r in recordings if (v := r.channels.get(channel)) is not None]
    white = noise_of([v[r.fresh(channel)] for r, v in logged])
    if any(r.held(channel) for r, _ in logged):
        return white  # too few rows are its own to see a colour
    if white is None:
        return None
    still = still_noise([r for r, _ in logged], [v for _, v in logged])
    if still is None or not is_coloured([still.value[s] for s in still.spans]):
        return white
    still = without_lines(still)
    if not is_coloured([still.value[s] for s in still.spans]):
        return white
    return max(white, total_noise(still))


def still_noise(recordings: Sequence[Recording], channel: Sequence[Array]) -> Joined | None:
    """Noise of a channel, one array (n,) for each recording, where it is still: the stretches, each
    less its slow trend.  None where there is not ENOUGH stillness.
    """
    stretches = [
        (r, s, bent(values[s])) for r, values in zip(recordings, channel, strict=True) for s in still_rows(r)
    ]
    if not stretches:
        return None
    variances = np.array([np.var(v) for _, _, v in stretches])
    usual = float(np.median(variances))
    found = [
        Remainder(r.name, "wrist", r.time[s], v, 1.0, {})
        for (r, s, v), variance in zip(stretches, variances, strict=True)
        if variance <= DISTURBED * usual
    ]
    if sum(float(np.ptp(f.time)) for f in found) < ENOUGH or usual == 0.0:
        return None
    if max(len(f.value) for f in found) < FEWEST:  # a slow log: no stretch has rows enough for a spectrum
        return None
    return join(found)


def still_rows(recording: Recording) -> list[slice]:
    """Rows of a recording where the command has not moved for SETTLED seconds."""
    time, command = recording.time, recording.command
    begins, at = [0], 0
    for i in (np.flatnonzero(np.diff(command)) + 1).tolist():
        if abs(command[i] - command[at]) > MOVED:
            begins.append(i)
            at = i
    found = []
    for begin, end in zip(begins, [*begins[1:], len(time)], strict=True):
        first = int(np.searchsorted(time, time[begin] + SETTLED))
        if first < end and time[end - 1] - time[first] >= SHORTEST:
            found.append(slice(first, end))
    return found


def bent(values: Array) -> Array:
    """Values (n,) less a polynomial of degree BENT."""
    from numpy.polynomial import Legendre

    x = np.linspace(-1.0, 1.0, len(values))
    found: Array = values - Legendre.fit(x, values, BENT, domain=[-1.0, 1.0])(x)
    return found


def total_noise(joined: Joined) -> float:
    """Standard deviation of the noise in stretches of stillness, with the part too slow to show in them.

    White and first-order noise, whose correlation time of at most LONGEST_MEMORY is that of the
    greatest likelihood (Whittle's, on the periodogram above SLOWEST cycles a stretch).
    """
    power, at = _whitened_periodogram(joined)
    edges = _edges(joined, at)
    count = np.diff(np.append(edges, len(at))).astype(float)
    level = np.add.reduceat(power, edges) / count
    best, total = np.inf, 0.0
    for memory in np.geomspace(joined.dt / 2.0, LONGEST_MEMORY, 30):
        shape = np.add.reduceat(first_order(at, memory, joined.dt), edges) / count
        model = np.stack([np.ones(len(shape)), shape], axis=1)
        fitted = level
        for _ in range(5):
            weight = np.sqrt(count) / fitted
            parts = positive_parts(model * weight[:, None], level * weight)
            fitted = model @ parts
        unlikely = float(np.sum(count * (np.log(fitted) + level / fitted)))
        if unlikely < best:
            best, total = unlikely, float(np.sqrt(np.sum(parts)))
    return total


def _whitened_periodogram(joined: Joined) -> tuple[Array, Array]:
    """Power at frequencies [Hz].  Of differences, and divided by what they do to it: a steep spectrum
    leaks upwards from a stretch that is cut off, theirs does not."""
    from scipy.fft import rfft

    total, rows = np.zeros(len(joined.frequencies)), 0
    for span in joined.spans:
        values = joined.value[span]
        total += np.abs(rfft(values[1:] - KEPT * values[:-1], joined.length)) ** 2
        rows += len(values) - 1
    gain = 1.0 - 2.0 * KEPT * np.cos(2.0 * np.pi * joined.frequencies * joined.dt) + KEPT**2
    return total / rows / gain, joined.frequencies


def _edges(joined: Joined, at: Array) -> NDArray[np.int64]:
    """First index of bands of frequencies [Hz] that widen upwards."""
    usual = float(np.median([s.stop - s.start for s in joined.spans])) * joined.dt
    edges = [SLOWEST / usual]
    while edges[-1] < at[-1]:
        edges.append(max(1.25 * edges[-1], edges[-1] + 0.05))
    return np.unique(np.searchsorted(at, edges[:-1]))


def without_lines(joined: Joined) -> Joined:
    """The series less the waves of a sinusoid, fitted in each stretch by itself."""
    for _ in range(LINES):
        line = line_in(joined, spectrum_of(joined, background(joined)))
        if line is None or line.evidence.p_value > SURE:
            break
        joined = replace(joined, value=_without_hum(joined, line.frequency))
    return joined


def _without_hum(joined: Joined, near: float) -> Array:
    """The series less the waves of the frequency near one [Hz] that fit best.

    Over all stretches a loud sinusoid is known more closely than from the peak of its spectrum.
    """
    from scipy.optimize import minimize_scalar

    def left(frequency: float) -> Array:
        waves = harmonic(joined, frequency)
        found: Array = joined.value - np.linalg.solve(waves @ waves.T, waves @ joined.value) @ waves
        return found

    reach = 0.2 / joined.longest
    best = minimize_scalar(
        lambda f: float(np.sum(left(f) ** 2)), bounds=(near - reach, near + reach), method="bounded",
        options={"maxiter": 12},
    )  # fmt: skip
    return left(float(best.x))
