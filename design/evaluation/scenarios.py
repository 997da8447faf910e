"""Scenarios of a tuning: the step of the rig, from every starting memory, on every plant.

Tuning puts the task on the nominal plant and on corners around it; what is
reported of a tuned controller is `design.comparison.compare`'s business.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from plants.equilibrium import obstacle
from plants.kernel import pytrees as tree
from plants.rig import Rig, built_in_rig
from plants.wrist import STARTS, Start, State, Wrist

STEP = built_in_rig().task.step
"""Size of the step of the built-in rig [deg]."""


_PAPER = built_in_rig().uncertainty


@dataclass(frozen=True)
class Scenario:
    """One run of the loop: a wrist at rest at an angle [deg], having come there by `start`, is
    stepped to a reference [deg]; `plant` says in words which wrist it is."""

    start: Start
    angle: float
    reference: float
    wrist: Wrist
    plant: str = "nominal"

    @property
    def name(self) -> str:
        """In words, such as ``0 to +15 deg from line1, nominal plant``."""
        return f"{self.angle:+g} to {self.reference:+g} deg from {self.start}, {self.plant} plant".replace(
            "+0", "0"
        )


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


def tuning_scenarios(wrist: Wrist, spread: Spread | None = None) -> list[Scenario]:
    """The declared set that gains are tuned on: 90 scenarios.

    Both signs of the step from each of the four starting memories, and the
    return from each held step, on the nominal plant and the eight corners.
    """
    found, step = [], wrist.rig.task.step
    for name, plant in corners(wrist, spread or Spread.of(wrist.rig)):
        for start, reference in product(STARTS, (step, -step)):
            found.append(Scenario(start, 0.0, reference, plant, name))
        found.append(Scenario("line1", step, 0.0, plant, name))
        found.append(Scenario("line2", -step, 0.0, plant, name))
    return found


HEADROOM = 0.1
"""Command [V] that must be left beyond what holds a corner's reference, so that it can be reached."""


def within_reach(scenarios: Sequence[Scenario]) -> tuple[list[Scenario], list[Scenario]]:
    """Scenarios that a command in the range can hold, and corners that none can.

    A corner that the actuator cannot reach says nothing about gains, so tuning
    sets it aside (and reports it).  Scenarios of the nominal plant always stay:
    that the task itself is out of reach is an answer.
    """
    least, most = scenarios[0].wrist.rig.command_range
    low, high = least + HEADROOM, most - HEADROOM
    kept = [s for s in scenarios if s.plant == "nominal" or unreachable(s, low, high) == 0.0]
    return kept, [s for s in scenarios if s not in kept]


def stack(scenarios: Sequence[Scenario]) -> tuple[Wrist, State, Any]:
    """Wrist, states and references of many scenarios, leaves of shape (scenarios,); the wrists have
    effects of the same forms."""
    values = [s.wrist.values for s in scenarios]
    wrist = scenarios[0].wrist.made_of({n: np.array([v[n] for v in values], float) for n in values[0]})
    states = [tree.leaves(s.wrist.rest(s.start, s.angle)) for s in scenarios]
    state = tree.like(scenarios[0].wrist.rest(), list(np.array(states, float).T))
    return wrist, state, np.array([s.reference for s in scenarios], float)


def unreachable(scenario: Scenario, low: float, high: float) -> float:
    """By how many volts the command that holds the scenario's reference lies outside a range [V].

    The wrist is held on the line that it arrives on; 0 where the range suffices,
    infinite where no command at all does, for the reason that `hindrance` gives.

    >>> from plants import Wrist
    >>> unreachable(Scenario("virgin", 0.0, 15.0, Wrist.flexion()), 0.0, 4.0)
    0.0
    """
    p = scenario.wrist.hysteresis
    plus = scenario.reference > scenario.angle
    if hindrance(scenario):
        return float("inf")
    if scenario.wrist.effects:
        start: Start = "line1" if plus else "line2"
        pressure = scenario.wrist.rest(start, scenario.reference).pressure
    else:
        pressure = (p.ascending_pressure if plus else p.descending_pressure)(scenario.reference)
    command = pressure / scenario.wrist.regulator.gain
    return float(max(low - command, command - high, 0.0))


def hindrance(scenario: Scenario) -> str | None:
    """What keeps the scenario's wrist from its reference, or from its start, whatever the command: an
    end stop or a supply that is too low, in words.  None for a declared wrist, and where nothing does."""
    there: Start = "line1" if scenario.reference > scenario.angle else "line2"
    words = obstacle(scenario.wrist, there, scenario.reference)
    if words is None and scenario.start in ("line1", "line2"):
        words = obstacle(scenario.wrist, scenario.start, scenario.angle)
    return words
