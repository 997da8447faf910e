"""A worst case, and what the runs of a search are held against."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from design.controllers.controller import Controller
from design.controllers.pi import PI
from design.controllers.pi_two_dof import TwoDofPI
from design.evaluation.cases import Case, stack
from design.evaluation.runner import play
from design.evaluation.scenarios import tuning_scenarios, within_reach
from design.robustness.box import SHIFT, Box
from design.synthesis.requirements import Limits
from plants.parameters.quantities import Assumed, Parameter, ParameterSet
from plants.simulation.periodic import Periodic

Array = NDArray[np.float64]
Objective = Literal["excess", "cost"]
SIMULATED = ("overshoot_percent", "steady_error_percent", "total_variation_V", "settling_time_s")
"""Limits that a run shows; Ms, Mt and the delay margin belong to branches."""

ASIDE = 1e6
"""Height, in the minimisation, of a sequence that is set aside."""


@dataclass(frozen=True)
class Plain:
    """The worst of the plain tuning set under the same gains: in excess over the limits that a run
    shows (as a share, and of which limit) and in cost, each with the scenario's name."""

    excess: float
    excess_of: str
    excess_on: str
    cost_per_deg: float
    cost_on: str


@dataclass(frozen=True)
class Worst:
    """What was found.

    case: the scenario; plant: the parameter set of its wrist, dead time and load not included;
    metrics: of the last step, which begins at the true angle `start` [deg] and is of `size` [deg];
    values: what limits and cost were held against; objective: what was maximised in the end;
    excess: over the limits, as a share, and excess_of which; greatest_excess: of all runs;
    violated: limits that it breaks; cost_per_deg: IAE per degree [s]; evaluations: runs used, of
    which set_aside had a reference out of reach; plain: the worst of the tuning set; others: scenarios
    apart from this one that break a limit too, worst first.
    """

    case: Case
    plant: ParameterSet
    controller: Controller | Periodic
    objective: Objective
    metrics: dict[str, float]
    values: dict[str, float]
    start: float
    size: float
    excess: float
    excess_of: str
    greatest_excess: float
    violated: tuple[str, ...]
    evaluations: int
    set_aside: int
    plain: Plain
    others: tuple[Case, ...] = ()

    @property
    def cost_per_deg(self) -> float:
        """IAE of the last step per degree [s]."""
        return self.values["iae_deg_s"] / self.case.wrist.rig.task.step

    @property
    def settings(self) -> dict[str, float]:
        """The gains of a PI; of any other controller all settings that are numbers."""
        if isinstance(self.controller, PI):
            names = ("Kp", "Ki", "b", "Tf") if isinstance(self.controller, TwoDofPI) else ("Kp", "Ki")
            return {n: float(getattr(self.controller, n)) for n in names}
        return {n: float(v) for n, v in vars(self.controller).items() if isinstance(v, int | float)}

    @property
    def record(self) -> dict[str, object]:
        """The worst case for JSON."""
        c, asked = self.case, self.case.task
        return {
            "scenario": c.name,
            "start": asked.start,
            "angle_deg": asked.angle,
            "references_deg": list(asked.references),
            "holds_s": list(asked.holds),
            "dead_time_s": c.dead_time,
            "load_deg": asked.load,
            "load_at_s": asked.load_at,
            "parameters": {n: float(v) for n, v in c.wrist.values.items()},
            **self.settings,
            "objective": self.objective,
            "metrics": self.metrics,
            "values": self.values,
            "last_step_deg": self.size,
            "excess": self.excess,
            "excess_of": self.excess_of,
            "greatest_excess": self.greatest_excess,
            "violated": list(self.violated),
            "cost_per_deg_s": self.cost_per_deg,
            "evaluations": self.evaluations,
            "set_aside": self.set_aside,
            "others": [other.name for other in self.others],
            "plain_tuning_set": vars(self.plain),
        }


def excesses(values: dict[str, Array], limits: Limits) -> dict[str, Array]:
    """How far each limit that a run shows is exceeded, as a share of it; negative where it is held."""
    named = {n: v for n, v in limits.named.items() if n in SIMULATED}
    return {n: np.nan_to_num((values[n] - v) / (v or 1.0), nan=ASIDE, posinf=ASIDE) for n, v in named.items()}


def scores(values: dict[str, Array], limits: Limits, objective: Objective, step: float) -> Array:
    """What is maximised: the largest excess as a share, or the IAE over the step of the task [s]."""
    if objective == "cost":
        return values["iae_deg_s"] / step
    return np.asarray(np.max(list(excesses(values, limits).values()), axis=0), float)


def named_plant(box: Box, values: dict[str, float]) -> ParameterSet:
    """The box's plant with values of the search, each with the interval that it was found in."""
    parameters = dict(box.plant.parameters)
    for name, value in values.items():
        if name == SHIFT:  # of the disturbance, not of the plant
            continue
        p, (low, high) = parameters[name], box.bounds(name)
        why = f"worst case found by search within {low:.6g} to {high:.6g}"
        parameters[name] = Parameter(value, p.unit, min(p.low, value), max(p.high, value), Assumed(why))
    return replace(box.plant, title=f"{box.plant.axis}, worst case", parameters=parameters)


def plain_worst(
    box: Box, controller: Controller | Periodic, limits: Limits, duration: float, jobs: int | None
) -> Plain:
    """The worst of the plain tuning set on the box's plant, in runs of a duration [s], judged as the search
    judges."""
    scenarios, _ = within_reach(tuning_scenarios(box.wrist, duration=duration))
    values = play(stack(scenarios), controller, jobs=jobs).values
    beyond, cost = excesses(values, limits), values["iae_deg_s"] / box.wrist.rig.task.step
    dearest = int(np.argmax(cost))
    if not beyond:
        return Plain(-1.0, "", "", float(cost[dearest]), scenarios[dearest].name)
    name = max(beyond, key=lambda n: float(beyond[n].max()))
    worst = int(np.argmax(beyond[name]))
    return Plain(
        float(beyond[name][worst]), name, scenarios[worst].name, float(cost[dearest]), scenarios[dearest].name
    )
