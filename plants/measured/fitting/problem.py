"""What a fit minimises: simulated minus measured, over recordings, in units of the noise."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plants.measured.campaigns.begin import Begin, measured
from plants.measured.campaigns.playback import Playback
from plants.measured.fitting.stage import Form, Stage
from plants.parameters.quantities import ParameterSet
from plants.wrist import Wrist

Array = NDArray[np.float64]
BLOCK = 2.0
"""Residuals within so many seconds may be correlated in any way, as far as standard errors go."""

WILD = 1e6
"""Residual, over the noise, beyond which nothing more is learnt."""


def block_length(playbacks: Sequence[Playback]) -> float:
    """Length of the blocks [s]: `BLOCK`, less where recordings are short, so that there are blocks enough."""
    spans = [float(p.recording.time[-1] - p.recording.time[0]) for p in playbacks]
    return min(BLOCK, 0.25 * float(np.median(spans)))


@dataclass(frozen=True)
class FitProblem:
    """Residuals of a stage with some effects, for `plants.measured.fitting.estimate`; in units of the noise.

    A vector holds the parameters in `names`, then of each recording what is `free` of its start
    (``pressure``, ``angle`` or both).  Everything else is as in `values` and in the stage's begins.  rows:
    those that count; None for all.  jumps: by how much each row moves with the time of the jump before it;
    what such times explain is taken off the residuals.  None where there are no such times.
    """

    stage: Stage
    forms: tuple[Form, ...]
    names: tuple[str, ...]
    values: Mapping[str, float]
    rows: NDArray[np.bool_] | None = None
    free: tuple[str, ...] = ()
    jumps: Array | None = None

    @property
    def blocks(self) -> NDArray[np.intp]:
        """Blocks within which residuals may be correlated in any way, (rows,)."""
        return self.stage.blocks(block_length(self.stage.playbacks))

    def bounds(self, parameters: ParameterSet) -> Array:
        """Start, lower and upper bound of each entry of the vector, (3, n); the start is put inside."""
        known, scaled = parameters.parameters, parameters.rig.scaled
        kinds = {f"{f.NAME}.{n}": k for f in self.forms for n, k in f.kinds().items()}
        rows = []
        for n in self.names:
            low, high = (
                (known[n].low, known[n].high)
                if n in known
                else (scaled(kinds[n].low, kinds[n].unit), scaled(kinds[n].high, kinds[n].unit))
            )
            rows.append((float(np.clip(self.values[n], low, high)), low, high))
        for playback, begin in zip(self.stage.playbacks, self.stage.begins or (), strict=False):
            for entry in self.free:
                truth = measured(playback.recording, "pressure_kPa" if entry == "pressure" else "angle_deg")
                reach = 20.0 if truth is None else 3.0 * float(np.ptp(truth[:20])) + 1.0
                first = getattr(begin, entry)
                rows.append((first, first - reach, first + reach))
        return np.array(rows, float).reshape(-1, 3).T

    def begins_at(self, x: Array) -> tuple[Begin, ...] | None:
        """The starts that one vector (n,), or vectors (n, lanes), stand for."""
        begins = self.stage.begins
        if begins is None or not self.free:
            return begins
        entries = np.reshape(x[len(self.names) :], (len(begins), len(self.free), *np.shape(x)[1:]))
        found = []
        for begin, row in zip(begins, entries, strict=True):
            moved: Any = {n: v if np.ndim(v) else float(v) for n, v in zip(self.free, row, strict=True)}
            found.append(replace(begin, **moved))
        return tuple(found)

    def residuals(self, x: Array) -> Array:
        """Simulated minus measured over noise, (rows, lanes), for vectors (lanes, n); lane after lane in
        memory, as linear algebra takes them."""
        begun, wrists = self._begun(x)
        found = np.empty((self.stage.edges[-1], len(x)), order="F")

        def played(i: int) -> Array:
            first, last = self.stage.edges[i : i + 2]
            into: Array = found[first:last]
            return np.subtract(begun.play(i, wrists), self.stage.target[first:last, None], out=into)

        begun.of_each_recording(played, len(x))
        found = self._off_jumps(self._over_noise(found))
        return found if self.rows is None else found[self.rows]

    def _begun(self, x: Array) -> tuple[Stage, Wrist]:
        """The stage, its recordings starting where vectors say, and the wrists that they stand for."""
        stage = replace(self.stage, begins=self.begins_at(x.T)) if self.free else self.stage
        values: dict[str, Any] = {**self.values, **{n: x[:, k] for k, n in enumerate(self.names)}}
        return stage, stage.wrists(values, self.forms)

    def _over_noise(self, difference: Array) -> Array:
        """A difference in units of the noise, in place."""
        difference /= self.stage.noise
        # A wrist that runs away is a bad fit, not the end of the search.
        np.clip(difference, -WILD, WILD, out=difference)
        difference[np.isnan(difference)] = WILD
        return difference

    def _off_jumps(self, residuals: Array) -> Array:
        """Residuals (rows, lanes) less what the times of jumps explain of them, in place."""
        if self.jumps is None:
            return residuals
        starts, moves = self.stage.jumps, self.jumps[:, None]
        size = np.add.reduceat(moves**2, starts)
        along = np.add.reduceat(moves * residuals, starts)
        share = np.divide(along, size, out=np.zeros_like(along), where=size > 0.0)
        residuals -= moves * np.repeat(share, np.diff(np.append(starts, len(residuals))), axis=0)
        return residuals

    def off_jumps(self, x: Array) -> "FitProblem":
        """The same problem with residuals off what times of jumps explain, at a vector (n,), where these were
        estimated in turn with the parameters: what a parameter does that a time would do as well tells
        nothing of it."""
        if not self.stage.timed:
            return self
        values = {**self.values, **dict(zip(self.names, map(float, x), strict=False))}
        stage = replace(self.stage, begins=self.begins_at(x))
        return replace(self, jumps=stage.moved_by_jumps(Wrist.from_values(values, self.forms, stage.rig)))

    def on(self, rows: NDArray[np.bool_] | None) -> "FitProblem":
        """The same problem on some rows."""
        return replace(self, rows=rows)
