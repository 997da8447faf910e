"""What was asked of the rig: so that an effect that sits in the command is not named as one of the rig.

Under a single sine a sinusoid at its harmonic, in one ramp a drift, at the first rows a load step, fit all
that the model does not make of the command.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from plants.measured.campaigns.playback import Playback
from plants.measured.campaigns.recording import Recording
from plants.measured.instrument.single_sine import line
from plants.measured.trace.ranking.contact import pressed_beyond

Array = NDArray[np.float64]
MOST = 0.4
"""Share of the time of all recordings that single sines, or ramps, have to fill to be what was asked."""

NEAR, NEARLY = 0.5, 0.05
"""How far a frequency may lie from a multiple of a line, in widths of the line: at all, and an order."""

RAMP = 0.9
"""Correlation of a command with time from which on it is one ramp."""

INSIDE, TURNS = 0.05, 6
"""How far a command has to turn back, and from the ends of its range, to make a minor loop, as a share of
that range; and how often at least."""

BEGINS = 0.03
"""Share of a recording that counts as its beginning; a second at least, and a period of a single sine, in
which the rig has yet to meet its whole range."""


@dataclass(frozen=True)
class Excitation:
    """What the commands of some recordings are.

    lines: frequency [Hz] of each single sine, and how finely it is known [Hz], empty where the commands hold
    more; ramp: whether each is one ramp; begins: time [s] up to which the recordings only begin; longest [s];
    minor_loops: whether they turn round inside their range too; recordings: themselves.
    """

    lines: tuple[tuple[float, float], ...]
    ramp: bool
    begins: float
    longest: float
    minor_loops: bool = True
    recordings: tuple[Recording, ...] = field(default=(), repr=False, compare=False)

    def pressed_beyond(self, angle: float, way: float) -> float:
        """By how much of its range the drive goes on while the joint stays at an angle [deg]."""
        return pressed_beyond(self.recordings, angle, way)

    def harmonic(self, frequency: float, orders: int = 20) -> int | None:
        """Which multiple of a line a frequency [Hz] is, as far as the recordings tell; None for none."""
        for own, width in self.lines:
            order = max(1, round(frequency / own))
            if order <= orders and abs(frequency - order * own) < width * max(NEAR, NEARLY * order):
                return order
        return None


def excitation(playbacks: Sequence[Playback]) -> Excitation:
    """What was asked in the recordings of a stage."""
    recordings = [p.recording for p in playbacks]
    spans = np.array([float(r.time[-1] - r.time[0]) for r in recordings])
    lines = [line(r) for r in recordings]
    share = float(spans[[f is not None for f in lines]].sum() / spans.sum())
    alone = tuple(f for f in lines if f is not None) if share >= MOST else ()
    ramps = np.array([_is_ramp(r) for r in recordings])
    begins = min(
        float(r.time[0]) + max(1.0, BEGINS * s, 1.0 / f[0] if f is not None else 0.0)
        for r, s, f in zip(recordings, spans, lines, strict=True)
    )
    ramp = bool(spans[ramps].sum() >= MOST * spans.sum())
    turns = inner_turns(recordings) >= TURNS
    return Excitation(alone, ramp, begins, float(spans.max()), turns, tuple(recordings))


def inner_turns(recordings: Sequence[Recording]) -> int:
    """How often commands turn round inside the range that all of them span together.

    >>> t = np.arange(600) / 100
    >>> sine = Recording("sine", t, 2.0 + np.sin(2.0 * np.pi * t))
    >>> inner_turns([sine]), inner_turns([sine, Recording("small", t, 2.0 + 0.3 * np.sin(2.0 * np.pi * t))])
    (0, 12)
    """
    from scipy.signal import find_peaks

    low = min(float(r.command.min()) for r in recordings)
    high = max(float(r.command.max()) for r in recordings)
    margin, count = max(INSIDE * (high - low), 1e-9), 0
    for r in recordings:
        turns = [find_peaks(way * r.command, prominence=margin)[0] for way in (1.0, -1.0)]
        level = r.command[np.concatenate(turns)]
        count += int(np.count_nonzero((level > low + margin) & (level < high - margin)))
    return count


def _is_ramp(recording: Recording) -> bool:
    if np.ptp(recording.command) == 0.0:
        return False
    return bool(abs(np.corrcoef(recording.time, recording.command)[0, 1]) > RAMP)
