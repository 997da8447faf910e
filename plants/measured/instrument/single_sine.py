"""Whether a command is a single sine, under which a delay, a lag and an unequal speed are all one phase."""

from collections.abc import Sequence

import numpy as np

from plants.measured.campaigns.recording import Recording

SINGLE = 0.7
"""Share of a command's power in one line from which on it is a single sine, or a wave of that period."""


FEWEST = 1.75
"""Periods of a sine that is told from what goes up and down once, as a staircase does."""


def only_sines(recordings: Sequence[Recording]) -> bool:
    """Whether each of some recordings has a single sine for a command; False where there is none."""
    return bool(recordings) and all(line(r) is not None for r in recordings)


def line(recording: Recording) -> tuple[float, float] | None:
    """Frequency of the single sine that a command is and the width of its line [Hz], None for another one.

    >>> t = np.arange(6000) / 100
    >>> f, width = line(Recording("sine", t, 2.0 + np.sin(2.0 * np.pi * 0.1 * t)))
    >>> abs(f - 0.1) < width
    True
    """
    dt = float(np.median(np.diff(recording.time)))
    asked = recording.command - recording.command.mean()
    n = len(asked)
    if n < 16 or not np.any(asked):
        return None
    size = 8 * n
    power = np.abs(np.fft.rfft(asked * np.hanning(n), size)) ** 2
    k = int(np.argmax(power[1:])) + 1
    reach = 2 * size // n  # half the main lobe of the window
    inside = power[max(k - reach, 0) : k + reach + 1].sum()
    if k < FEWEST * size / n or inside < SINGLE * power.sum():
        return None
    return k / (size * dt), 1.0 / (n * dt)
