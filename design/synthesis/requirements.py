"""Hard limits on a PI, the cost that is minimised under them, and where: a tuning problem."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from design.evaluation.cases import Case, stack
from design.evaluation.runner import Lanes
from design.evaluation.scenarios import Spread, tuning_scenarios, within_reach
from design.margins import LINEAR, BranchResponse, branch_responses
from plants.rig import Rig, built_in_rig
from plants.simulation.disturbance import burdened, dead_time_left
from plants.simulation.sensor import HOLD, PERFECT, Sensor
from plants.wrist import Wrist

Array = NDArray[np.float64]
Cost = Literal["iae", "itae", "settling_time"]
COSTS: dict[str, str] = {"iae": "iae_deg_s", "itae": "itae_deg_s2", "settling_time": "settling_time_s"}
"""Costs to choose from, and the metric that each is."""


_PAPER = built_in_rig().limits


@dataclass(frozen=True)
class Limits:
    """Limits that a tuned PI meets on every scenario and branch; None drops one.

    overshoot_percent: simulated, of the step.  Ms: peak of the sensitivity on
    {transit, line 1, line 2} x {slow, fast}.  delay_margin_s: dead time that may
    come on top; 60 ms, since rigs of this kind show about 50 ms of tube.
    total_variation_V: total variation of the command in one step.  steady_error_percent:
    error at the end of the run, of the step.  Mt: peak of the complementary sensitivity, on the
    same branches as Ms.  settling_time_s: until the step is settled; a run's duration asks that it does so
    at all.  WT: peak of |W T|, of a plant whose residual is unmodelled dynamics of weight W; the requirement
    sets it to 1.  The defaults are those of the built-in rig.
    """

    overshoot_percent: float | None = _PAPER["overshoot_percent"]
    Ms: float | None = _PAPER["Ms"]
    delay_margin_s: float | None = _PAPER["delay_margin_s"]
    total_variation_V: float | None = _PAPER["total_variation_V"]
    steady_error_percent: float | None = _PAPER["steady_error_percent"]
    Mt: float | None = _PAPER["Mt"]
    settling_time_s: float | None = _PAPER["settling_time_s"]
    WT: float | None = None

    @classmethod
    def none(cls) -> "Limits":
        """No limit at all."""
        return cls(**dict.fromkeys((f.name for f in fields(cls)), None))

    @classmethod
    def of(cls, rig: Rig) -> "Limits":
        """What a rig's task asks for; what it does not name is not limited."""
        return cls(**{f.name: rig.limits.get(f.name) for f in fields(cls)})

    @property
    def named(self) -> dict[str, float]:
        """The limits that are in force, by name."""
        return {f.name: v for f in fields(self) if (v := getattr(self, f.name)) is not None}


NOMINAL = replace(Limits(), delay_margin_s=None)
"""Limits for a rig without dead time, which no real one is."""


ROUNDING = 1.0005
"""A tuned optimum lies on its limit; half a per mille keeps rounding from breaking it."""

LIMIT_UNITS = {
    "overshoot_percent": "%", "Ms": "1", "delay_margin_s": "s", "total_variation_V": "V",
    "steady_error_percent": "%", "command_range": "V", "Mt": "1", "settling_time_s": "s", "WT": "1",
}  # fmt: skip


@dataclass(frozen=True)
class Problem:
    """A plant, the scenarios to be tuned on, the cost and the limits.

    lanes: the scenarios side by side.  adverse: cases whose last step joins the scenarios in all that is
    simulated, scaled to the task's step (`design.evaluation.scaled.scaled`); none by default.
    Of these only steps of the task (`Case.of_task`) count for the cost.  sensor: that of the adverse cases;
    its noise is the same in each, so that gains are compared under one.  branches: where margins are judged.
    guard: shares of limits that gains must stay below them by.  screened: gains that break a limit of the
    linear loop are not simulated: their cost is infinite and the rest of their values no number.
    """

    wrist: Wrist
    scenarios: tuple[Case, ...]
    limits: Limits
    cost: str
    branches: tuple[BranchResponse, ...]
    lanes: Lanes
    jobs: int | None = None
    set_aside: tuple[Case, ...] = ()
    adverse: tuple[Case, ...] = ()
    guard: Mapping[str, float] = field(default_factory=dict, hash=False)
    screened: bool = False
    sensor: Sensor = PERFECT

    @property
    def held_to(self) -> dict[str, float]:
        """The limits in force, less their guard."""
        return {n: v * (1.0 - self.guard.get(n, 0.0)) for n, v in self.limits.named.items()}

    @cached_property
    def adverse_lanes(self) -> list[tuple[NDArray[np.intp], Lanes]]:
        """The adverse cases as batches of about the same length, each with the places of its lanes."""
        lasts = np.array([c.task.duration for c in self.adverse])
        order = np.argsort(lasts, kind="stable")
        pieces = [p for p in np.split(order, np.flatnonzero(np.diff(lasts[order]) > 1.0) + 1) if p.size]
        return [(p, self._measured(stack([self.adverse[i] for i in p]))) for p in pieces]

    def _measured(self, lanes: Lanes) -> Lanes:
        """Lanes with the sensor of the adverse cases."""
        if not self.sensor.noise:
            return replace(lanes, sensor=self.sensor)
        drawn = np.random.default_rng(0).standard_normal(-(-lanes.samples // HOLD) + 1)
        return replace(lanes, sensor=self.sensor, noise=np.tile(drawn[:, None], lanes.count))

    @classmethod
    def of(
        cls,
        wrist: Wrist,
        scenarios: Sequence[Case],
        limits: Limits | None = None,
        cost: str = "iae",
        duration: float | None = None,
        jobs: int | None = None,
    ) -> "Problem":
        """The problem of tuning a wrist; corners that no command can hold are set aside.

        duration [s] for which each is judged, its own where not given.
        Raises ValueError for an unknown cost.
        """
        if cost not in COSTS:
            raise ValueError(f"unknown cost {cost!r}; one of {', '.join(COSTS)}")
        if duration is not None:
            scenarios = [replace(c, task=replace(c.task, holds=(duration,))) for c in scenarios]
        kept, aside = within_reach(scenarios)
        return cls(
            wrist, tuple(kept), limits or Limits.of(wrist.rig), cost, tuple(branch_responses(wrist)),
            stack(kept), jobs, tuple(aside),
        )  # fmt: skip

    def place(self, limit: str, index: int) -> str:
        """In words, the scenario or branch that an entry of ``values_at`` points to; with ``cost`` as
        the limit, that of ``cost_at``."""
        if limit in LINEAR:
            b = self.branches[index]
            return f"{b.branch}, {b.rate} regulator rate"
        if index < len(self.scenarios):
            return self.scenarios[index].name
        return self.adverse[index - len(self.scenarios)].name


def default_problem(
    wrist: Wrist,
    limits: Limits | None = None,
    cost: str = "iae",
    nominal: bool = False,
    jobs: int | None = None,
    spread: Spread | None = None,
) -> Problem:
    """The problem that ``wrist tune`` solves: all scenarios, or the step from rest of the nominal plant."""
    scenarios = tuning_scenarios(wrist, spread)
    if nominal:
        scenarios = [s for s in scenarios if (s.plant, s.task.start) == ("nominal", "virgin")]
    return Problem.of(wrist, scenarios, limits, cost, jobs=jobs)


def late_problem(
    wrist: Wrist,
    limits: Limits | None = None,
    cost: str = "iae",
    dead_time: float | None = None,
    duration: float | None = None,
    jobs: int | None = None,
) -> Problem:
    """All scenarios behind a dead time [s], the longest that the rig states if not given, which is in the
    margins too; a plant with a dead time of its own has what is left of it beside that.

    >>> from plants.wrist import Wrist
    >>> problem = late_problem(Wrist.flexion())
    >>> {float(s.wrist.values["dead-time.delay"]) for s in problem.scenarios}, len(problem.branches)
    ({0.05}, 12)
    """
    late = dead_time_left(wrist, wrist.rig.uncertainty.dead_time[1] if dead_time is None else dead_time)
    if late == 0.0:
        return default_problem(wrist, limits, cost, jobs=jobs)
    scenarios = [replace(s, wrist=burdened(s.wrist, late, None)) for s in tuning_scenarios(wrist)]
    plain = Problem.of(wrist, scenarios, limits, cost, duration, jobs)
    both = (*branch_responses(wrist), *branch_responses(burdened(wrist, late, None)))
    return replace(plain, branches=both, screened=True)


def excesses(values: Mapping[str, Array], limits: Mapping[str, float]) -> dict[str, Array]:
    """How far each value lies beyond its limit, as a share of the limit; not above 0 where it is held."""
    found = {}
    for name, limit in limits.items():
        beyond = limit - values[name] if name == "delay_margin_s" else values[name] - limit
        found[name] = beyond / (limit or 1.0)  # a limit of zero has no share of itself
    return found
