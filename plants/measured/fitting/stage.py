"""One measured channel of a campaign, and what wrists with effects make of it.

Stages are traced one after the other: the regulator on the pressure, then the
wrist on the angle, driven by the pressure that the explained regulator gives.
(Measured pressure would count its noise as motion.)  Where no pressure was
logged there is one stage, from the command to the angle.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from plants.dynamics import settled
from plants.effects import EFFECTS
from plants.effects.effect import Around, Effect
from plants.equilibrium import beside, effects_at_rest, static_angle
from plants.kernel.batches import in_turn_or_side_by_side
from plants.kernel.templates import LANES
from plants.measured.campaigns.begin import Begin, measured, without_shift
from plants.measured.campaigns.playback import Playback
from plants.measured.campaigns.recording import Recording
from plants.measured.fitting.blocks import blocks, judged_blocks
from plants.parameters.quantities import REGULATOR_NAMES
from plants.rig import Rig
from plants.simulation.open_loop import driven
from plants.wrist import State, Wrist

Array = NDArray[np.float64]
Name = Literal["regulator", "wrist", "whole"]
Form = type[Effect]
STRIDES = (1, 2, 5)
"""Steps of ms that a driven wrist may take between rows.  Its loop does not depend on the rate and
its lag is exact for a pressure that moves linearly, so that fewer steps do as well."""


@dataclass(frozen=True)
class Stage:
    """A channel to explain, in recordings that may be fitted on.

    name: ``regulator`` (command to pressure), ``wrist`` (pressure to angle), or
    ``whole`` (command to angle).  noise: floor of the channel.  loop: parameters of hysteresis and joint
    that are fitted; rig: whose motion was recorded.  drives: pressure
    [kPa] of every ms, for ``wrist``; free_drives: that simulated from the command, where `drives` holds what
    was measured too.  begins: where recordings start, None at rest.  guessed: whether the rig was, from the
    log; form: error of the channel that the forms of a hysteresis law that was chosen from the log, and of a
    regulator before it, may leave.
    """

    name: Name
    channel: str
    noise: float
    playbacks: tuple[Playback, ...]
    loop: tuple[str, ...]
    rig: Rig
    drives: tuple[Array, ...] | None = None
    begins: tuple[Begin, ...] | None = None
    free_drives: tuple[Array, ...] | None = None
    form: float = 0.0
    guessed: bool = False

    @property
    def freely(self) -> "Stage":
        """The stage in a free run from the command."""
        return self if self.free_drives is None else replace(self, drives=self.free_drives, free_drives=None)

    @property
    def declared(self) -> tuple[str, ...]:
        """Names of the declared parameters that act in this stage."""
        both = (*REGULATOR_NAMES, *self.loop)
        return {"regulator": REGULATOR_NAMES, "wrist": self.loop, "whole": both}[self.name]

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of the effects that act in this stage."""
        of_regulator = [n for n, forms in EFFECTS.items() if forms[0].STAGE == "regulator"]
        if self.name == "whole":
            return tuple(EFFECTS)
        return tuple(n for n in EFFECTS if (n in of_regulator) == (self.name == "regulator"))

    @property
    def parts(self) -> int:
        """How many parts of the rig act in it, of regulator and joint."""
        return 2 if self.name == "whole" else 1

    @cached_property
    def target(self) -> Array:
        """What was measured, all recordings end to end, (rows,)."""
        return np.concatenate([self._measured(p.recording) for p in self.playbacks])

    @cached_property
    def edges(self) -> NDArray[np.intp]:
        """First row of each recording, and the number of rows."""
        return np.cumsum([0, *(len(p.recording.time) for p in self.playbacks)])

    @cached_property
    def time(self) -> Array:
        """Time [s] of each row, (rows,)."""
        return np.concatenate([p.recording.time for p in self.playbacks])

    @property
    def duration(self) -> float:
        """Time of all recordings in all [s]."""
        return sum(float(p.recording.time[-1] - p.recording.time[0]) for p in self.playbacks)

    @cached_property
    def left_out_blocks(self) -> NDArray[np.intp]:
        """Number of the block, of those that are left out in turn, that each row falls in."""
        return judged_blocks([p.recording.time for p in self.playbacks])

    def blocks(self, length: float) -> NDArray[np.intp]:
        """Number of the block of a length [s] that each row falls in; none spans two recordings."""
        return blocks([p.recording.time for p in self.playbacks], length)

    def simulate(self, values: Mapping[str, Any], forms: Sequence[Form] = ()) -> Array:
        """The channel of wrists with effects, shape (rows, lanes); leaves of `values` floats or (lanes,)."""
        wrist = self.wrists(values, forms)
        lanes = max(map(np.size, wrist.values.values()))
        return np.concatenate(self.of_each_recording(lambda i: self.play(i, wrist), lanes))

    def of_each_recording(self, work: Callable[[int], Array], lanes: int) -> list[Array]:
        """Results of a function of the index of a recording, which plays so many wrists in it."""
        steps = sum(int(p.rows[-1]) // self._stride(p) for p in self.playbacks) * -(-lanes // LANES)
        return in_turn_or_side_by_side(work, range(len(self.playbacks)), steps)

    def _stride(self, playback: Playback) -> int:
        """Samples of the rig's sample time that a wrist is advanced by at once in a recording."""
        return 1 if self.drives is None else max(k for k in STRIDES if playback.every % k == 0)

    def wrists(self, values: Mapping[str, Any], forms: Sequence[Form] = ()) -> Wrist:
        """Wrists with effects side by side; leaves of `values` floats or (lanes,)."""
        lanes = max((np.size(v) for v in values.values()), default=1)
        across = {n: np.broadcast_to(np.asarray(v, float), lanes) for n, v in values.items()}
        return Wrist.from_values(across, tuple(forms), self.rig)

    def _measured(self, recording: Recording) -> Array:
        found = measured(recording, self.channel)
        assert found is not None
        return found

    def play(self, i: int, wrist: Wrist) -> Array:
        """The channel of wrists in the i-th recording, (rows, lanes)."""
        playback = self.playbacks[i]
        state = self._state(i, wrist)
        if self.name == "regulator":
            return playback.press(wrist, state)
        if self.drives is None:
            pressure, angle = playback.play(wrist, state)
            return pressure if self.channel == "pressure_kPa" else angle
        stride = self._stride(playback)
        other = playback.other_pressure
        rows = driven(
            wrist, self.drives[i][::stride], state, playback.every // stride, 1,
            None if other is None else other[::stride], float(playback.recording.time[0]),
            stride * playback.dt,
        )  # fmt: skip
        return playback.as_logged(rows[playback.kept], self.channel)

    @property
    def timed(self) -> bool:
        """Whether times of jumps of the command, ahead of their rows, that move the channel were estimated:
        in a stage that a pressure drives they are in that pressure."""
        return self.drives is None and any(p.recording.ahead is not None for p in self.playbacks)

    @cached_property
    def jumps(self) -> NDArray[np.intp]:
        """Rows, of all recordings end to end, at which commands jumped and at which recordings begin."""
        of_each = (np.append(0, np.flatnonzero(p.jumped)) for p in self.playbacks)
        return np.concatenate([first + at for first, at in zip(self.edges, of_each, strict=False)])

    def moved_by_jumps(self, wrist: Wrist) -> Array:
        """By how much a wrist's channel moves for each second that the last jump of its command comes
        earlier, (rows,): of each jump what it does until the next."""
        return np.concatenate([self.moved_by_jumps_of(i, wrist)[1] for i in range(len(self.playbacks))])

    def moved_by_jumps_of(self, i: int, wrist: Wrist) -> tuple[Array, Array]:
        """The channel of a wrist in the i-th recording, and by how much it moves with its jumps, (rows,)."""
        playback, simulated = self.playbacks[i], self.play(i, wrist)
        at = np.flatnonzero(playback.jumped)
        if not len(at):
            return simulated, np.zeros_like(simulated)
        ahead, row = playback.ahead[at], np.diff(playback.recording.time, prepend=np.nan)[at]
        by = np.where(ahead < 0.5 * row, 0.25, -0.25) * row
        moved = self.with_recording(i, playback.jumping(ahead + by)).play(i, wrist)
        lasts = np.diff(np.concatenate([[0], at, [len(simulated)]]))
        return simulated, (moved - simulated) / np.repeat(np.append(np.inf, by), lasts)

    def with_recording(self, i: int, playback: Playback) -> "Stage":
        """The stage with another i-th recording."""
        return replace(self, playbacks=(*self.playbacks[:i], playback, *self.playbacks[i + 1 :]))

    def _state(self, i: int, wrist: Wrist) -> State | None:
        return begun(wrist, None if self.begins is None else self.begins[i])


def begun(wrist: Wrist, begin: Begin | None) -> State | None:
    """The state of a wrist, effects included, in which a recording starts; None at rest.

    Effects have come to rest where the recording begins, not where the wrist would rest by itself: a line
    that delays holds the pressure [kPa] that is there, and what creeps has crept.
    """
    if begin is None or not wrist.effects:
        return None if begin is None else begin.state(wrist.hysteresis)
    c, around = wrist.sampled(), Around(other_pressure=begin.other)
    if begin.other and not begin.virgin:
        at = _state(wrist, begin)
        shift = settled(at, c, around).angle - settled(at, c, Around()).angle
        begin = without_shift(begin, shift, float(np.median(wrist.hysteresis.rest_pressure)), wrist.rig)
    if not begin.at_zero:
        virgin = begin.on_virgin_curve(wrist.hysteresis)
        held = (begin.rest if virgin else begin.angle) - beside(wrist, begin.pressure)
        static = static_angle(wrist, held, against=False)
        begin = replace(begin, rest=static) if virgin else replace(begin, angle=static)
    return settled(_state(wrist, begin), c, around)


def _state(wrist: Wrist, begin: Begin) -> State:
    """The state with the loop where a recording starts, and the effects at rest there."""
    at = begin.state(wrist.hysteresis)
    return at._replace(effects=effects_at_rest(wrist, at.pressure, at.memory.h))
