"""What a fit minimises: simulated minus measured, over recordings, in units of the noise."""

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plants.dynamics import Number
from plants.hysteresis import HysteresisLaw
from plants.kernel.batches import default_jobs
from plants.measured.playback import Playback
from plants.measured.recording import Recording
from plants.parameters.quantities import ParameterSet
from plants.rig import Rig
from plants.wrist import State, Wrist

Array = NDArray[np.float64]
BLOCK = 2.0
"""Residuals within so many seconds may be correlated in any way, as far as standard errors go."""


def block_length(playbacks: Sequence[Playback]) -> float:
    """Length of the blocks [s]: `BLOCK`, less where recordings are short, so that there are blocks enough."""
    spans = [float(p.recording.time[-1] - p.recording.time[0]) for p in playbacks]
    return min(BLOCK, 0.25 * float(np.median(spans)))


@dataclass(frozen=True)
class Begin:
    """Where a recording starts that does not start at rest: pressure [kPa], angle [deg], and
    whether the wrist is still on its virgin curve."""

    pressure: float
    angle: float
    virgin: bool

    def state(self, loop: HysteresisLaw) -> State:
        """The state of a wrist with a loop; on the virgin curve the static angle is 0."""
        return begun(loop, self.pressure, self.angle, self.virgin)


def begun(loop: HysteresisLaw, pressure: Number, angle: Number, virgin: bool) -> State:
    """A wrist at rest at a pressure [kPa] and an angle [deg], on the virgin curve or between the branches."""
    memory = loop.initial() if virgin else loop.resting("inside", angle, pressure)
    return State(pressure, memory, angle)


def first_begin(recording: Recording, rest_pressure: float) -> Begin:
    """The start that the first rows of a recording show.

    Where a channel was not logged the wrist's rest stands in for it.  A wrist at
    rest in both is taken to be on the virgin curve.
    """
    pressure = rest_pressure if recording.pressure is None else float(np.median(recording.pressure[:3]))
    angle = 0.0 if recording.angle is None else float(np.median(recording.angle[:3]))
    return Begin(pressure, angle, at_rest(recording, rest_pressure))


def at_rest(recording: Recording, rest_pressure: float) -> bool:
    """Whether the first rows of a recording look like a wrist that rests at its rest pressure."""
    off = 0.0 if recording.pressure is None else float(np.median(recording.pressure[:3])) - rest_pressure
    angle = 0.0 if recording.angle is None else float(np.median(recording.angle[:3]))
    return abs(off) < 5.0 and abs(angle) < 1.0


def measured(recording: Recording, channel: str) -> Array | None:
    """A measured channel of a recording by its column name, None where it was not logged."""
    return recording.pressure if channel == "pressure_kPa" else recording.angle


@dataclass(frozen=True)
class FitProblem:
    """Residuals of lanes of vectors, for `plants.measured.estimate`.

    A vector holds the parameters in `names`, then of each recording what is
    `free` of its start (``pressure``, ``angle`` or both).  Everything else is as
    in `values` and `begins`; `begins` is None where all recordings start at rest.
    noise: what each channel is divided by.
    """

    playbacks: tuple[Playback, ...]
    values: Mapping[str, float]
    names: tuple[str, ...]
    channel: str
    noise: float
    rig: Rig
    begins: tuple[Begin, ...] | None = None
    free: tuple[str, ...] = ()

    @property
    def blocks(self) -> NDArray[np.intp]:
        """Number of the block of time that each residual falls in, (rows,)."""
        numbers = [
            1e6 * i + np.floor((p.recording.time - p.recording.time[0]) / block_length(self.playbacks))
            for i, p in enumerate(self.playbacks)
        ]
        return np.unique(np.concatenate(numbers), return_inverse=True)[1]

    def bounds(self, parameters: ParameterSet) -> Array:
        """Start, lower and upper bound of each entry of the vector, shape (3, n)."""
        known = parameters.parameters
        rows = [(self.values[n], known[n].low, known[n].high) for n in self.names]
        for playback, begin in zip(self.playbacks, self.begins or (), strict=False):
            for entry in self.free:
                truth = measured(playback.recording, "pressure_kPa" if entry == "pressure" else "angle_deg")
                reach = 20.0 if truth is None else 3.0 * float(np.ptp(truth[:20])) + 1.0
                first = getattr(begin, entry)
                rows.append((first, first - reach, first + reach))
        return np.array(rows, float).reshape(-1, 3).T

    def wrist(self, x: Array) -> Wrist:
        """Wrists of vectors (lanes, n)."""
        lanes = {n: np.full(len(x), v) for n, v in self.values.items()}
        return Wrist.from_values({**lanes, **{n: x[:, i] for i, n in enumerate(self.names)}}, rig=self.rig)

    def begins_at(self, x: Array) -> tuple[Begin, ...] | None:
        """The starts that one vector (n,) stands for."""
        if self.begins is None:
            return None
        entries = np.reshape(x[len(self.names) :], (len(self.begins), len(self.free)))
        return tuple(
            Begin(**{**vars(begin), **dict(zip(self.free, map(float, row), strict=True))})
            for begin, row in zip(self.begins, entries, strict=True)
        )

    def residuals(self, x: Array) -> Array:
        """Simulated minus measured, shape (rows, lanes) for vectors (lanes, n)."""
        with ThreadPoolExecutor(default_jobs()) as pool:
            return np.concatenate(
                list(pool.map(lambda i: self.residuals_of(i, x), range(len(self.playbacks))))
            )

    def residuals_of(self, i: int, x: Array) -> Array:
        """The same for the i-th recording alone."""
        playback = self.playbacks[i]
        pressure, angle = playback.play(self.wrist(x), self._state(i, x))
        truth = measured(playback.recording, self.channel)
        assert truth is not None
        simulated = pressure if self.channel == "pressure_kPa" else angle
        difference: Array = (simulated - truth[:, None]) / self.noise
        return difference

    def _state(self, i: int, x: Array) -> State:
        if self.begins is None:
            return self.wrist(x).rest()
        offset = len(self.names) + i * len(self.free)
        begin = self.begins[i]
        entries = {n: x[:, offset + j] for j, n in enumerate(self.free)}
        pressure, angle = entries.get("pressure", begin.pressure), entries.get("angle", begin.angle)
        return begun(self.wrist(x).hysteresis, pressure, angle, begin.virgin)
