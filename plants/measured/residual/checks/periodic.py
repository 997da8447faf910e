"""Search for lines in the spectrum of a residual: a sinusoid of one frequency, in all recordings."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plants.measured.residual.checks.evidence import Evidence
from plants.measured.residual.series.background import periodogram
from plants.measured.residual.series.joined import Joined
from plants.measured.residual.series.remainder import Array

LOWEST_LINE = 0.25
"""Frequencies [Hz] below this are wander, or the rhythm of the experiment, not a hum."""

BESIDE = 0.6
"""Half-width [Hz] of the surroundings that a line must stand out of."""

SEGMENT = 12.0
"""Length [s], or PERIODS if longer, of the segments in most of which a steady sinusoid is there."""

PERIODS = 8.0
STEADY = 0.75
"""Share of the segments in which a sinusoid has at least half, and at most double, its typical size."""


@dataclass(frozen=True)
class Line:
    """A sinusoid at a frequency [Hz]: test of the highest value of the spectrum; steady: whether it is
    there all the time, and not made of something that recurs in one recording."""

    frequency: float
    evidence: Evidence
    steady: bool

    @property
    def name(self) -> str:
        """In words, with its frequency [Hz]."""
        return f"periodic at {self.frequency:.3g} Hz"


@dataclass(frozen=True)
class Spectrum:
    """Power of the residual over its surroundings: frequency [Hz], value, bound, (m,) each."""

    frequency: Array
    value: Array
    level: Array
    shape: float

    def bound(self, p: float) -> Array:
        """What the power stays below everywhere with probability 1 - p, for noise alone."""
        from scipy.stats import gamma

        return self.level * float(gamma.isf(min(1.0, p / self.trials), self.shape)) / self.shape

    @property
    def trials(self) -> float:
        """Number of independent values, somewhat overstated."""
        return 2.0 * len(self.value)


def spectrum_of(joined: Joined, noise: Array) -> Spectrum:
    """Power of the residual, and its level around each frequency, from medians that pass over lines."""
    from numpy.lib.stride_tricks import sliding_window_view
    from scipy.stats import gamma

    power, shape = periodogram(joined)
    step = float(joined.frequencies[1])
    beside, stride = round(BESIDE / step), max(1, round(0.1 / step))
    # A median every tenth of a hertz is enough, and much quicker than one at every frequency.
    padded = np.pad(power / noise, beside, mode="reflect")
    surroundings = sliding_window_view(padded, 2 * beside + 1)[::stride]
    medians = np.median(surroundings, axis=1) * shape / gamma.ppf(0.5, shape)
    level = np.interp(joined.frequencies, joined.frequencies[::stride], medians)
    return Spectrum(joined.frequencies, power, noise * np.maximum(level, 1.0), shape)


def line_in(joined: Joined, spectrum: Spectrum) -> Line | None:
    """The strongest line; None where the recordings are too short to have one."""
    allowed = spectrum.frequency >= max(LOWEST_LINE, 4.0 / joined.longest)
    if not np.any(allowed):
        return None
    ratio = np.where(allowed, spectrum.value / spectrum.level, 0.0)
    k = int(np.argmax(ratio))
    frequency, level = _refined(spectrum, k), float(spectrum.level[k])
    waves = harmonic(joined, frequency)
    along = waves @ joined.value
    inverse = np.linalg.pinv(waves @ waves.T, hermitian=True)
    power = (float(along @ inverse @ along) - level * len(waves)) / joined.rows
    found = Evidence(
        float(ratio[k]), "gamma", (spectrum.shape, 0.0, 1.0 / spectrum.shape), spectrum.trials, power
    )
    return Line(frequency, found, _steady(joined, frequency, level))


def harmonic(joined: Joined, frequency: float) -> NDArray[np.float64]:
    """Sine and cosine of a frequency [Hz] in each recording, (2 recordings, n)."""
    columns = np.zeros((2 * len(joined.spans), len(joined.value)))
    for i, span in enumerate(joined.spans):
        phase = 2.0 * np.pi * frequency * joined.dt * np.arange(span.stop - span.start)
        columns[2 * i, span], columns[2 * i + 1, span] = np.cos(phase), np.sin(phase)
    return columns


def _refined(spectrum: Spectrum, k: int) -> float:
    """Frequency of a peak [Hz], from a parabola through the logarithms of three values."""
    if not 0 < k < len(spectrum.value) - 1:
        return float(spectrum.frequency[k])
    a, b, c = np.log(spectrum.value[k - 1 : k + 2])
    bend = a - 2.0 * b + c
    shift = 0.5 * (a - c) / bend if bend < 0.0 else 0.0
    return float(spectrum.frequency[k] + shift * spectrum.frequency[1])


def _steady(joined: Joined, frequency: float, level: float) -> bool:
    """Whether a wave of a frequency [Hz] has about the same size in most segments."""
    rows = round(max(SEGMENT, PERIODS / frequency) / joined.dt)
    wave = np.exp(-2j * np.pi * frequency * joined.dt * np.arange(rows))
    powers = [
        abs(wave @ joined.value[a : a + rows]) ** 2 / rows - level
        for span in joined.spans
        for a in range(span.start, span.stop - rows + 1, rows)
    ]
    if len(powers) < 2:
        return False
    typical = float(np.median(powers))
    within = [0.25 * typical < p < 4.0 * typical for p in powers]
    return typical > 2.0 * level and float(np.mean(within)) >= STEADY
