"""Scenarios of a tuning: the step of the rig, from every starting memory, on every plant.

Tuning puts the task on the nominal plant and on corners around it; what is
reported of a tuned controller is `design.comparison.compare`'s business.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

from design.evaluation.cases import Case, unreachable
from design.evaluation.tasks import tuning_tasks
from plants.rig import Rig, built_in_rig
from plants.wrist import Wrist

STEP = built_in_rig().task.step
"""Size of the step of the built-in rig [deg]."""


_PAPER = built_in_rig().uncertainty


@dataclass(frozen=True)
class Spread:
    """How far the corners of the plant lie from its nominal values, as shares of them.

    The defaults are those of the built-in rig, and assumed: what the practice of refitting a
    pneumatic rig shows from day to day, not a measured uncertainty of this one.
    """

    width: float = _PAPER.width  # of both offsets w1, w2: the loop's width
    slope: float = _PAPER.slope  # of all slopes together
    lag: float = _PAPER.lag  # of Tw

    @classmethod
    def of(cls, rig: Rig) -> "Spread":
        """What a rig declares."""
        return cls(rig.uncertainty.width, rig.uncertainty.slope, rig.uncertainty.lag)


def corner(wrist: Wrist, width: float, slope: float, lag: float) -> Wrist:
    """The wrist with its loop wider, its slopes steeper and its lag longer by factors."""
    v, roles = wrist.values, wrist.hysteresis.roles(wrist.hysteresis.values)
    loop = {n: v[n] * slope for n in (*roles["outer"], *roles["inner"])} | {
        n: v[n] * width for n in roles["width"]
    }
    return wrist.with_values(**loop, Tw=wrist.Tw * lag)


def corners(wrist: Wrist, spread: Spread) -> list[tuple[str, Wrist]]:
    """The nominal plant and the eight corners of loop width, slope and lag, with their names."""
    found = [("nominal", wrist)]
    for signs in product((-1, 1), repeat=3):
        words = zip(signs, ("narrow", "flat", "quick"), ("wide", "steep", "slow"), strict=True)
        name = " ".join(plus if sign > 0 else minus for sign, minus, plus in words)
        factors = (1.0 + sign * size for sign, size in zip(signs, vars(spread).values(), strict=True))
        found.append((name, corner(wrist, *factors)))
    return found


def tuning_scenarios(wrist: Wrist, spread: Spread | None = None, duration: float | None = None) -> list[Case]:
    """The declared set that gains are tuned on: 90 scenarios.

    Both signs of the step from each of the four starting memories, and the
    return from each held step, on the nominal plant and the eight corners; each for a duration [s], that of
    the rig's task where not given.
    """
    asked, plants = tuning_tasks(wrist.rig, duration), corners(wrist, spread or Spread.of(wrist.rig))
    return [Case(task, plant, name) for name, plant in plants for task in asked]


HEADROOM = 0.1
"""Command [V] that must be left beyond what holds a corner's reference, so that it can be reached."""


def within_reach(scenarios: Sequence[Case]) -> tuple[list[Case], list[Case]]:
    """Scenarios that a command in the range can hold, and corners that none can.

    A corner that the actuator cannot reach says nothing about gains, so tuning
    sets it aside (and reports it).  Scenarios of the nominal plant always stay:
    that the task itself is out of reach is an answer.
    """
    least, most = scenarios[0].wrist.rig.command_range
    low, high = least + HEADROOM, most - HEADROOM
    kept = [s for s in scenarios if s.plant == "nominal" or unreachable(s, low, high) == 0.0]
    return kept, [s for s in scenarios if s not in kept]
