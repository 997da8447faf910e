"""What a residual depends on, in order of evidence: each name for what those before it leave."""

from dataclasses import dataclass, field

import numpy as np

from plants.measured.residual.battery import Battery, correlated, events_of, sizes_over
from plants.measured.residual.checks.conditional import Sums
from plants.measured.residual.checks.events import LONGEST_SHARE
from plants.measured.residual.checks.evidence import Evidence
from plants.measured.residual.checks.size import evened, is_rough
from plants.measured.residual.series.remainder import Array

MINOR = 0.1
"""What accounts for less than this part of what the first name does is not worth a name."""

MOST = 3
"""Most names of variables."""


@dataclass
class _Names:
    """Names found so far: their power, and the variable whose columns are regressed out."""

    battery: Battery
    power: dict[str, float] = field(default_factory=dict)
    variables: dict[str, str] = field(default_factory=dict)

    @property
    def columns(self) -> list[int]:
        return sorted({j for v in self.variables.values() for j in self.battery.design.where[v]})

    @property
    def left(self) -> Sums:
        return self.battery.sums.without(self.columns)

    def worth(self, kind: str, evidence: Evidence) -> bool:
        """Whether evidence that the names so far leave is worth a further name."""
        return self.battery.counts(kind, evidence) and evidence.power > MINOR * max(
            self.power.values(), default=0.0
        )

    def add(self, name: str, power: float, variable: str | None = None) -> None:
        self.power[name] = max(power, self.power.get(name, 0.0))
        if variable is not None:
            self.variables[name] = variable

    def drop(self, name: str) -> None:
        del self.power[name], self.variables[name]

    def rest(self) -> Array:
        """The residual without what is named."""
        j = self.columns
        if not j:
            return self.battery.joined.value
        fitted = self.battery.sums.coefficients(j).astype(np.float32) @ self.battery.design.columns[j]
        found: Array = self.battery.joined.value - fitted
        return found


def named(battery: Battery, seed: int) -> tuple[str, ...]:
    """Names of what the residual depends on.

    First the variables and the sinusoid, greedily: the one that accounts for most, then the one that accounts
    for most of what is left.  Then what no variable explains: wander, events, changing size.
    """
    names = _Names(battery)
    _name_variables(names)
    _name_wander(names)
    rest = names.rest()
    for c in correlated(battery.joined, rest, battery.noise_spectrum):
        e = c.evidence(float(np.mean(rest[battery.joined.inside] ** 2)))
        if names.worth("cross-correlation", e):
            names.add(c.variable, e.power)
    sizes = sizes_over(battery, rest, seed).values()
    changing = any(battery.counts("changing size", e) for e in sizes)
    changing = changing and is_rough(battery.joined, rest, battery.noise_spectrum)
    # Loud noise makes excursions of its own: events are what still stands out for its surroundings.
    level = evened(battery.joined, rest, battery.noise_spectrum) if changing else rest
    events = events_of(battery, level)
    if names.worth("events", events.evidence) and events.duty < LONGEST_SHARE:
        names.add("events", events.evidence.power)
    ordered = sorted(names.power, key=lambda n: -names.power[n])
    if changing:
        ordered.append("changing size")
    # A drift from zero, or a loop that lies askew, has a mean too: an offset is what is nothing else.
    return tuple(ordered or dict.fromkeys(_plain(*key) for key in battery.found()))


def _plain(kind: str, variable: str) -> str:
    """Name of what a test found."""
    if kind == "changing size":
        return kind
    return "time" if variable == "time_s" else variable


def _name_wander(names: _Names) -> None:
    """Name ``time`` where the means over stretches of time differ still.

    A variable that only grows with time follows any wander somewhat: it is dropped
    where the stretches explain all that it did.
    """
    battery = names.battery
    wander = names.left.test(battery.design.where["time"], battery.freedom)
    if not names.worth("conditional mean", wander):
        return
    for name, variable in list(names.variables.items()):
        others = [j for v in names.variables.values() if v != variable for j in battery.design.where[v]]
        without = battery.sums.without(others + battery.design.where["time"])
        left = without.test(battery.design.where[variable], battery.freedom)
        if name != "time" and not names.worth("conditional mean", left):
            names.drop(name)
    wander = names.left.test(battery.design.where["time"], battery.freedom)
    names.add("time", wander.power, "time")


def _name_variables(names: _Names) -> None:
    battery = names.battery
    line = battery.line
    open_ = [b.variable for b in battery.bins if b.variable != "time"]
    if line is not None and line.steady and battery.counts("periodic", line.evidence):
        open_.append(line.name)
    while open_ and len(names.power) < MOST:
        left = names.left
        tests = {v: left.test(battery.design.where[v], battery.freedom) for v in open_}
        best = max(open_, key=lambda v: tests[v].power)
        if not names.worth("conditional mean", tests[best]):
            return
        names.add("time" if best == "time_s" else best, tests[best].power, best)
        open_.remove(best)
