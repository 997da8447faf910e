"""The requirement: what gains have to hold, stated once for tuning, samples, the worst case and the verdict.

Limits, on every plant of a box, behind every dead time of its interval, from every starting memory, in every
kind of case that a rig meets: the task's step either way, returns that come before or after the step has
settled, sequences of other references, load steps.  Ms, Mt and the delay margin hold on every branch of the
hysteresis at both rates of the regulator on every corner of the box, the dead time in.

Whoever judges gains (`robust_tuning`, `checks`, `assess`) asks this one value.
"""

from dataclasses import asdict, dataclass, replace
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.controllers.pi import PI
from design.evaluation.cases import Case
from design.evaluation.runner import play
from design.evaluation.scenarios import Spread
from design.evaluation.tasks import tuning_tasks
from design.margins import BranchResponse, Margins, branch_responses, margins, with_dynamics
from design.robustness.box import SIGMAS, Box, box_of
from design.robustness.samples.conditions import Conditions, beside
from design.robustness.samples.draws import generator
from design.robustness.samples.search_space import KINDS, Kind, Space
from design.robustness.samples.worst import excesses
from design.synthesis.requirements import Limits, Problem
from design.synthesis.requirements import excesses as shares_beyond
from plants.effects.effect import dead_time_of
from plants.effects.wrist.remainder import ColouredRemainder
from plants.kernel import pytrees
from plants.parameters.quantities import ParameterSet
from plants.simulation.disturbance import burdened
from plants.simulation.sensor import HOLD, Sensor, sensor
from plants.wrist import Wrist

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
POINTS = 400
"""Frequencies at which margins on corners are taken."""

MOST_CORNERS = 8
"""Parameters whose every combination of ends is taken; of more, those that move the response most."""


@dataclass(frozen=True)
class Requirement:
    """Limits that hold on the plants of a box under conditions, in cases of some kinds.

    cost: what a tuning under it minimises, of the task's steps; duration [s] for which a step is judged.
    WT is limited to 1 where the box has unmodelled dynamics, and only there, on the nominal plant's branches.
    """

    box: Box
    limits: Limits
    conditions: Conditions
    kinds: tuple[Kind, ...] = KINDS
    cost: str = "iae"
    duration: float = 10.0

    def __post_init__(self) -> None:
        robust = None if self.box.weight is None else 1.0
        object.__setattr__(self, "limits", replace(self.limits, WT=robust))

    @property
    def wrist(self) -> Wrist:
        """The nominal plant."""
        return self.box.wrist

    @property
    def sensor(self) -> Sensor:
        """The sensor of the angle, with its noise and its resolution."""
        return sensor(self.conditions.noise, self.conditions.quantum)

    @cached_property
    def space(self) -> Space:
        """Every case, as places of a cube; a dead time or a load of the plant's own varies within the box."""
        met = beside(self.wrist, self.conditions)
        kinds = tuple(k for k in self.kinds if k != "load" or met.load > 0.0)
        return Space(self.box, 3, met.dead_time, met.load, self.duration, kinds)

    @cached_property
    def branches(self) -> tuple[BranchResponse, ...]:
        """Responses on every branch at both rates on every corner of the box, without the dead time and with
        the longest, none twice."""
        wrists = [burdened(w, t, None) for w in self.corners() for t in (0.0, self.space.dead_time)]
        found: dict[Any, BranchResponse] = {}
        for number, wrist in enumerate(wrists):
            # A residual is what the nominal plant leaves; what a corner would leave, nobody measured.
            weight = self.box.weight if number < 2 else None
            for b in with_dynamics(branch_responses(wrist, POINTS), weight):
                few = [x[:: POINTS // 4] for x in (b.response, b.pressure)]
                key = tuple(np.round([x / np.abs(x), np.log(np.abs(x))], 9).tobytes() for x in few)
                found.setdefault(key, b)
        return tuple(found.values())

    def corners(self) -> list[Wrist]:
        """The nominal wrist, and those at the ends of the intervals that move a response at all."""
        middle = np.full(len(self.box.intervals), 0.5)
        before = _stacked(self.box.at(middle))
        moved = []
        for i in range(middle.size):
            ends = [_stacked(self.box.at(_with(middle, i, share))) for share in (0.0, 1.0)]
            moved.append(max(_moved(before, e) for e in ends))
        order = np.argsort(moved)[::-1]
        chosen = [int(i) for i in order if moved[i] > 1e-9][:MOST_CORNERS]
        found = []
        for shares in product((0.0, 1.0), repeat=len(chosen)):
            place = middle.copy()
            place[chosen] = shares
            found.append(self.box.at(place))
        return [self.box.at(middle), *found]

    def margins(self, controller: PI) -> Margins:
        """Margins of a PI, gains floats or arrays, the worst over every branch of every corner."""
        return margins(self.branches, controller)

    def linear_excess(self, controller: PI) -> dict[str, float]:
        """By what share of each limit of the linear loop a PI lies beyond it; not above 0 where it holds."""
        found = self.margins(controller).values
        limits = {n: v for n, v in self.limits.named.items() if n in found}
        return {n: float(v) for n, v in shares_beyond(found, limits).items()}

    def run(
        self, x: Array, controller: Any, noise_seed: tuple[int, int] | None = None, jobs: int | None = None
    ) -> dict[str, Array]:
        """What limits of a run and the cost are held against at places x, shape (size, lanes), by name, each
        (lanes,), settings of the controller floats or lanes.

        noise_seed: seed and number of the piece, where the sensor is noisy and counts in quanta.
        """
        found: dict[str, Array] = {}
        for lanes in self._alike(x, noise_seed is not None):
            c = _lanes_of(controller, lanes, x.shape[1])
            asked = self.space.lanes(x[:, lanes])
            if noise_seed is not None:
                seed, piece = noise_seed
                draw = generator(seed, piece, 2 + int(lanes[0])).standard_normal
                asked = replace(asked, sensor=self.sensor)
                if self.conditions.noise > 0.0:
                    asked = replace(asked, noise=draw((-(-asked.samples // HOLD) + 1, lanes.size)))
            for name, v in play(asked, c, jobs=jobs).values.items():
                found.setdefault(name, np.empty(x.shape[1]))[lanes] = v
        return found

    def _alike(self, x: Array, noisy: bool) -> list[NDArray[np.intp]]:
        """Lanes by how long they last, so that short ones do not wait for long ones; in groups where each
        draws noise of its own."""
        lasts = self.space.asked(x)["holds"].sum(axis=0)
        if not noisy:
            return [np.argsort(lasts, kind="stable")] if lasts.size else []
        groups = np.digitize(lasts, (self.duration + 0.1, self.duration + 3.0, self.duration + 6.0))
        return [np.flatnonzero(groups == g) for g in np.unique(groups)]

    def excess(self, values: dict[str, Array], guard: dict[str, float] | None = None) -> Array:
        """The largest excess of runs over the limits less their guard, as a share of each, (lanes,)."""
        held = {n: v * (1.0 - (guard or {}).get(n, 0.0)) for n, v in self.limits.named.items()}
        beyond = excesses(values, replace(self.limits, **held))
        return np.asarray(np.max(list(beyond.values()), axis=0), float)

    @cached_property
    def telling(self) -> tuple[BranchResponse, ...]:
        """Those of the branches that decide for some gains, over a wide map: a search needs no others."""
        Kp, Ki = (g.ravel() for g in np.meshgrid(np.geomspace(0.5, 20.0, 12), np.geomspace(0.5, 60.0, 12)))
        found = self.margins(PI.of(self.wrist, Kp, Ki))
        stable = np.isfinite(found.Ms)
        if not stable.any():
            return self.branches
        decide = np.concatenate([x[stable] for x in found.at.values()])
        return tuple(self.branches[i] for i in np.unique(decide))

    def problem(self, guard: dict[str, float] | None = None, jobs: int | None = None) -> Problem:
        """The tuning problem to begin with: the nominal plant's steps and the margins; cases are added."""
        scenarios = [Case(t, self.wrist) for t in tuning_tasks(self.wrist.rig, self.duration)]
        plain = Problem.of(self.wrist, scenarios, self.limits, self.cost, jobs=jobs)
        return replace(plain, branches=self.telling, guard=guard or {}, screened=True)


def requirement(
    plant: ParameterSet,
    limits: Limits | None = None,
    conditions: Conditions | None = None,
    spread: Spread | None = None,
    given: dict[str, tuple[float, float]] | None = None,
    cost: str = "iae",
    sigmas: float = SIGMAS,
) -> Requirement:
    """The requirement that a plant's rig states: its limits, its box, its conditions; each may be given.
    The residual of the plant's angle is a disturbance in every case, and where it has a weight unmodelled
    dynamics, against which the linear loop is robustly stable (WT at most 1).

    >>> from plants.parameters.files import built_in
    >>> stated = requirement(built_in("flexion"))
    >>> stated.conditions.dead_time, stated.limits.overshoot_percent, stated.kinds
    (0.05, 5.0, ('step', 'return', 'sequence', 'load'))

    Raises InputError as `design.robustness.box.box_of`.
    """
    rig = plant.rig
    box = box_of(plant, spread or Spread.of(rig), sigmas, given)
    box = box.leaving(ColouredRemainder.of(plant.remainder.get("angle_deg")))
    return Requirement(
        box, limits or Limits.of(rig), conditions or Conditions.of(rig), cost=cost,
        duration=rig.task.duration,
    )  # fmt: skip


def requirement_record(asked: Requirement) -> dict[str, Any]:
    """A requirement for JSON; longest_dead_time_s with the plant's own."""
    late, left, weight = asked.space.dead_time, asked.box.remainder, asked.box.weight
    dynamics = {} if weight is None else {"weight": asdict(weight)}
    return {
        "limits": asked.limits.named, "box": {i.name: [i.low, i.high] for i in asked.box.intervals},
        "remainder": None if left is None else {"peak": left.peak, "length": left.length, **dynamics},
        "dead_time_s": [0.0, late], "longest_dead_time_s": late + float(dead_time_of(asked.wrist.effects)),
        "load": asked.space.load, "noise": asked.conditions.noise, "resolution": asked.conditions.quantum,
        "kinds": list(asked.space.kinds), "cost": asked.cost,
    }  # fmt: skip


def _with(shares: Array, i: int, share: float) -> Array:
    found = shares.copy()
    found[i] = share
    return found


def _moved(before: NDArray[np.complex128], after: NDArray[np.complex128]) -> float:
    """By what share responses change at most; without bound where other branches occur."""
    return float(np.abs(after / before - 1.0).max()) if before.shape == after.shape else float("inf")


def _stacked(wrist: Wrist) -> NDArray[np.complex128]:
    """All responses of a wrist at a few frequencies."""
    return np.concatenate([b.response for b in branch_responses(wrist, 12)])


def _lanes_of(controller: Any, lanes: NDArray[np.intp], count: int) -> Any:
    """The controllers of some lanes."""
    leaves = pytrees.leaves(controller) if hasattr(controller, "sampled") else []
    if all(np.size(v) != count or count == 1 for v in leaves):
        return controller
    return pytrees.like(controller, [np.asarray(v)[lanes] if np.size(v) == count else v for v in leaves])
