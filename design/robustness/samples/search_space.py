"""Where the worst case is searched for: a cube whose places are cases on plants of a box.

Coordinates, each from 0 to 1: those of the box; the starting memory (four equal parts); the references,
each within the task's step either way and at least `SMALLEST` of it from the one before; how long all
but the last are held (log-spaced, from `BRIEF` on, the one before the last calmly, see
`design.evaluation.tasks.calm`); dead time and load where they are searched; and, where a space has several
`kinds` of cases, which it is (equal parts):

    sequence   as above
    step       the task's step from rest, either way
    return     the task's step, held from `BRIEF` on, so often not settled, then back to 0 or to its mirror
    load       at rest at the task's step, either way, when the load comes
"""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from design.evaluation.cases import Case, as_lanes
from design.evaluation.runner import Lanes
from design.evaluation.scaled import SMALLEST
from design.evaluation.scenarios import HEADROOM
from design.evaluation.tasks import Task, calm
from design.robustness.box import Box
from design.robustness.samples.draws import LINES, kept_from
from plants.equilibrium import holding_command
from plants.simulation.disturbance import BEFORE, at_rest
from plants.wrist import STARTS, Wrist

Array = NDArray[np.float64]
BRIEF = 0.3
"""How long [s] the first references are held at least: the next may come in full motion."""

Kind = Literal["sequence", "step", "return", "load"]
SEQUENCES: tuple[Kind, ...] = ("sequence",)
KINDS: tuple[Kind, ...] = ("step", "return", "sequence", "load")
"""All kinds of cases that a requirement is about."""


@dataclass(frozen=True)
class Space:
    """What is searched: the box, so many references, dead time [s] from 0, load [deg] to either side.

    duration [s]: for which the last step is judged; kinds: of cases.  Places are arrays x of shape (size,
    lanes).
    """

    box: Box
    steps: int = 3
    dead_time: float = 0.0
    load: float = 0.0
    duration: float = 10.0
    kinds: tuple[Kind, ...] = SEQUENCES

    @property
    def size(self) -> int:
        """Number of coordinates."""
        own = len(self.box.intervals) + 2 * self.steps + (self.dead_time > 0.0) + (self.load > 0.0)
        return own + (len(self.kinds) > 1)

    def kind(self, x: Array) -> NDArray[np.intp]:
        """Which of the kinds each place is, (lanes,)."""
        if len(self.kinds) == 1:
            return np.zeros(x.shape[1], np.intp)
        return np.asarray(np.minimum(x[-1] * len(self.kinds), len(self.kinds) - 1), np.intp)

    @property
    def calm(self) -> tuple[float, float]:
        """How long [s] the reference before the last is held, see `design.evaluation.tasks.calm`."""
        return calm(self.box.wrist.rig)

    @property
    def hold(self) -> tuple[float, float]:
        """How long [s] the references before that are held, and the first angle of a return."""
        return BRIEF, self.calm[1]

    def of_task(self, x: Array) -> NDArray[np.bool_]:
        """Which places are steps of the task's size that begin calmly, from 0 or back to it, (lanes,)."""
        asked = self.asked(x)
        r, h = asked["references"], asked["holds"]
        back = (r[-1] == 0.0) & (h[-2] >= self.calm[0]) if self.steps > 1 else np.zeros(x.shape[1], bool)
        return np.asarray(self._are(x, "step") | (self._are(x, "return") & back), bool)

    def _are(self, x: Array, kind: Kind) -> NDArray[np.bool_]:
        known = kind in self.kinds
        return self.kind(x) == self.kinds.index(kind) if known else np.zeros(x.shape[1], bool)

    def asked(self, x: Array) -> dict[str, Any]:
        """What the wrists are asked at places x, as arguments of `design.evaluation.cases.as_lanes`."""
        first, n, lanes = len(self.box.intervals) + 1, self.steps, x.shape[1]
        angles, before = [], np.zeros(lanes)
        for share in x[first : first + n]:
            before = reference(share, before, self.box.wrist.rig.task.step)
            angles.append(before)
        shares = x[first + n : first + 2 * n - 1]
        bounds = [self.hold] * (n - 2) + [self.calm] * (n > 1)
        holds = [a * (b / a) ** share for share, (a, b) in zip(shares, bounds, strict=True)]
        more = list(x[first + 2 * n - 1 :])
        asked: dict[str, Any] = {
            "starts": [STARTS[min(int(4.0 * share), 3)] for share in x[first - 1]],
            "angle": np.zeros(lanes),
            "references": np.array(angles),
            "holds": np.array([*holds, np.full(lanes, self.duration)]),
            "dead_time": self.dead_time * more.pop(0) if self.dead_time > 0.0 else None,
            "load": self.load * (2.0 * more.pop(0) - 1.0) if self.load > 0.0 else None,
            "load_at": np.full(lanes, BEFORE),
        }
        if self.kinds != SEQUENCES:
            self._of_kinds(x, x[first : first + n], shares, asked)
        asked["holds"] = np.round(asked["holds"], 3)
        return asked

    def _of_kinds(self, x: Array, signs: Array, shares: Array, asked: dict[str, Any]) -> None:
        """Fills in what cases of the other kinds are asked, in place; a first reference that is held for no
        time is none."""
        step = self.box.wrist.rig.task.step
        way = np.where(signs[-1] < 0.5, -step, step)
        r, h = asked["references"], asked["holds"]
        single = self._are(x, "step") | self._are(x, "load")
        r[:, single], h[:-1, single] = way[single], 0.0
        back = self._are(x, "return")
        if self.steps > 1:
            low, high = self.hold
            r[:-1, back], h[:-2, back] = way[back], 0.0
            r[-1, back] = np.where(signs[0] < 0.5, 0.0, -way)[back]
            h[-2, back] = (low * (high / low) ** shares[-1])[back]
        loaded = self._are(x, "load")
        asked["angle"] = np.where(loaded, way, 0.0)
        asked["load_at"] = np.where(loaded, 0.0, BEFORE)
        for i in np.flatnonzero(loaded):
            asked["starts"][i] = LINES[int(way[i] < 0.0)]

    def wrist(self, x: Array) -> Wrist:
        """The wrists at places x, as lanes."""
        return self.box.at(x[: len(self.box.intervals)])

    def lanes(self, x: Array) -> Lanes:
        """The cases at places x, as lanes."""
        return as_lanes(self.wrist(x), **self.asked(x))

    def case(self, x: Array) -> tuple[Case, dict[str, float]]:
        """The case at one place x, shape (size,), and the values that the box gives its wrist."""
        asked = self.asked(x[:, None])
        values = {n: float(v) for n, v in self.box.values(x[: len(self.box.intervals)]).items()}
        dead_time, load = (0.0 if asked[n] is None else float(asked[n][0]) for n in ("dead_time", "load"))
        held = asked["holds"][:, 0] > 0.0
        references, holds = (tuple(map(float, asked[n][held, 0])) for n in ("references", "holds"))
        wrist, plant = self.box.at(x[: len(self.box.intervals)]), "worst-case"
        angle, load_at = float(asked["angle"][0]), float(asked["load_at"][0])
        task = Task(asked["starts"][0], angle, references, holds, "task band", load, load_at)
        return Case(task, wrist, plant, dead_time), values

    def reachable(self, x: Array) -> NDArray[np.bool_]:
        """Where every reference can be held: by a command in the range, less the headroom of the tuning
        set, on the line on which the wrist arrives, with no effect that keeps it from there; (lanes,)."""
        asked, n, (low, high) = self.asked(x), self.steps, self.box.wrist.rig.command_range
        angles = asked["references"].ravel()
        before = np.vstack([asked["angle"], asked["references"][:-1]]).ravel()
        # All references at once, as lanes: for a plant with effects, rest is found by bisection.
        wrist = self.wrist(np.tile(x, n))
        burden = [None if asked[k] is None else np.tile(asked[k], n) for k in ("dead_time", "load")]
        up, down = (at_rest(wrist, line, angles, *burden).pressure for line in LINES)
        # One that is asked for once more is held where it was arrived at.
        up_to = np.where(angles == before, angles > 0.0, angles > before)
        pressure = np.where(up_to, up, down)
        command = holding_command(wrist, pressure)
        held = (command >= low + HEADROOM) & (command <= high - HEADROOM)
        held &= ~kept_from(wrist, pressure, angles)
        return np.asarray(held.reshape(n, -1).all(axis=0))


def reference(share: Array, before: Array, step: float) -> Array:
    """References [deg] within the range of the task's step [deg] and at least the share `SMALLEST` of it
    from those before; a share of 0 is the lowest and of 1 the highest.

    >>> reference(np.array([0.0, 0.5, 1.0]), np.array([0.0, 12.0, -12.0]), 15.0).tolist()
    [-15.0, -4.0, 15.0]
    """
    smallest = SMALLEST * step
    below = np.maximum(before - smallest + step, 0.0)
    above = np.maximum(step - before - smallest, 0.0)
    way = share * (below + above)
    lower = (way <= below) & (below > 0.0)
    return np.asarray(np.where(lower, way - step, before + smallest + way - below), float)
