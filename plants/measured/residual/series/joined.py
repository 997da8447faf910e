"""Remainders of all recordings as one series, with silence between them, and its Fourier transform."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from plants.measured.residual.series.remainder import Array, Remainder

FEWEST, MOST = 90, 80_000
"""Rows of the longest recording, and of all, that an examination is made for."""

SILENCE = 4.0
"""Zeros between two recordings [s], longer than legal noise remembers."""


@dataclass(frozen=True)
class Joined:
    """The residuals one after the other, shape (n,), zero in the silences.

    dt: sample time [s]; spans: rows of each recording; inside: where there are rows; value: the
    residual, whose mean was taken off; mean: what was taken off; variables: by name, NaN where not
    logged and in the silences.
    """

    dt: float
    spans: tuple[slice, ...]
    inside: NDArray[np.bool_]
    value: Array
    mean: float
    variables: dict[str, Array]

    @property
    def rows(self) -> int:
        """Number of rows measured."""
        return int(np.count_nonzero(self.inside))

    def inner(self, margin: int) -> NDArray[np.bool_]:
        """Rows that are at least this many rows from the ends of their recording.

        At the ends filters see the silence, which is not what noise of their memory goes on with.
        """
        found = np.zeros(len(self.value), dtype=bool)
        for span in self.spans:
            found[span.start + margin : max(span.start + margin, span.stop - margin)] = True
        return found

    @property
    def duration(self) -> float:
        """Time measured [s]."""
        return self.rows * self.dt

    @property
    def longest(self) -> float:
        """Duration of the longest recording [s]."""
        return float(self.dt * max(s.stop - s.start for s in self.spans))

    @cached_property
    def length(self) -> int:
        """Length of the transforms."""
        from scipy.fft import next_fast_len

        return int(next_fast_len(len(self.value), real=True))

    @cached_property
    def frequencies(self) -> Array:
        """Frequencies of the transforms [Hz]."""
        return np.arange(self.length // 2 + 1) / (self.length * self.dt)

    @cached_property
    def counts(self) -> Array:
        """How often each of the frequencies counts in a sum over positive and negative ones."""
        counts = np.full(len(self.frequencies), 2.0)
        counts[0] = 1.0
        if self.length % 2 == 0:
            counts[-1] = 1.0
        return counts

    def transform(self, series: NDArray[np.floating]) -> NDArray[np.complexfloating]:
        """Fourier transform of series of shape (..., n)."""
        from scipy.fft import rfft

        found: NDArray[np.complexfloating] = rfft(series, self.length, axis=-1)
        return found

    def filtered(self, series: Array, gain: Array) -> Array:
        """A series (n,) filtered without shift of phase, by a gain for each frequency."""
        from scipy.fft import irfft

        found: Array = irfft(self.transform(series) * gain, self.length)[: len(series)]
        return found


def join(remainders: Sequence[Remainder]) -> Joined:
    """One series of all residuals of a stage.

    Of a log with more than MOST rows every second, third or so is taken.  Raises ValueError for none,
    for different stages, and where no recording has FEWEST rows.
    """
    if not remainders or len({r.stage for r in remainders}) > 1:
        raise ValueError("an examination needs remainders, all of the same stage")
    if max(len(r.value) for r in remainders) < FEWEST:
        raise ValueError(f"an examination needs a recording of at least {FEWEST} rows")
    every = -(-sum(len(r.value) for r in remainders) // MOST)
    if every > 1:
        remainders = [_thinned(r, every) for r in remainders]
    dt = float(np.median(np.concatenate([np.diff(r.time) for r in remainders])))
    gap = round(SILENCE / dt)
    spans, start = [], 0
    for r in remainders:
        spans.append(slice(start, start + len(r.value)))
        start += len(r.value) + gap
    inside = np.zeros(start, dtype=bool)
    value = np.zeros(start)
    names = list(dict.fromkeys(n for r in remainders for n in r.variables))
    found = {n: np.full(start, np.nan) for n in names}
    for r, span in zip(remainders, spans, strict=True):
        inside[span] = True
        value[span] = r.value
        for name, values in r.variables.items():
            found[name][span] = values
    mean = float(np.mean(value[inside]))
    value[inside] -= mean
    return Joined(dt, tuple(spans), inside, value, mean, found)


def _thinned(remainder: Remainder, every: int) -> Remainder:
    """Every so many-th row of a residual."""
    kept = {name: values[::every] for name, values in remainder.variables.items()}
    return replace(remainder, time=remainder.time[::every], value=remainder.value[::every], variables=kept)
