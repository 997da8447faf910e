"""What a plant may be: an interval for each parameter that is uncertain, and where it comes from.

A box is where certificates about parameters are to hold, where samples are drawn and where the
worst case is searched for.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

from design.evaluation.scenarios import Spread
from design.robustness.confidence_region import ConfidenceRegion
from design.robustness.intervals import (
    AssumedShare,
    Given,
    Interval,
    StandardErrors,
    half_width,
    narrowed,
    refuse_outside,
)
from plants.effects.wrist.remainder import ColouredRemainder
from plants.errors import InputError
from plants.hysteresis import Role
from plants.linearisation import branch_slopes
from plants.parameters.quantities import Fitted, ParameterSet
from plants.parameters.remainder import UncertaintyWeight
from plants.wrist import Wrist

Array = NDArray[np.float64]
SIGMAS = 2.0
"""Half-width of the interval of a fitted parameter, in standard errors."""

RATES = 0.2
"""Half-width of the intervals of an assumed regulator (its rates and e0), as a share; assumed."""


NARROWED = 20
"""Steps in which the intervals of a loop are narrowed where it would run backwards at a corner."""

SHIFT = "remainder.shift"
"""The interval that says which part of a residual a wrist meets."""

TOGETHER: Mapping[str, tuple[Role, ...]] = {"slopes": ("outer", "inner"), "widths": ("width",)}
"""Roles of parameters that, where nobody measured them, vary together by one factor: drawn apart, the
branches of the loop would cross."""


@dataclass(frozen=True)
class Box:
    """Intervals of a plant's parameters; the others keep the values of `plant`.

    Estimates lie within their intervals and, of many, within a joint confidence region besides: the more
    there are, the less likely is it that all lie at the ends of theirs.  Those whose errors are correlated
    vary together, as far as so many standard errors along each principal axis of their correlation take
    them.  remainder: what the plant leaves, as a disturbance of every wrist of the box; which part of it a
    wrist meets is the last of the intervals.
    """

    plant: ParameterSet
    intervals: tuple[Interval, ...]
    remainder: ColouredRemainder | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the intervals, in order."""
        return tuple(i.name for i in self.intervals)

    @property
    def wrist(self) -> Wrist:
        """The plant itself."""
        return Wrist.of(self.plant)

    @property
    def weight(self) -> UncertaintyWeight | None:
        """Weight of the unmodelled dynamics that the residual shows; None where it shows none."""
        left = self.plant.remainder.get("angle_deg")
        return None if self.remainder is None or left is None else left.weight

    @cached_property
    def region(self) -> ConfidenceRegion:
        """Where the estimates of the box lie together."""
        return ConfidenceRegion.of(self.intervals, self.plant.correlation)

    def coordinates(self, shares: Array) -> dict[str, Array]:
        """Values of the intervals, by their names, at places in the box: `shares` of shape (intervals, ...),
        0 at the lower and 1 at the upper end of each, or of each principal axis of what is correlated."""
        shares = self.region.within(np.asarray(shares, float))
        found = [i.low + (i.high - i.low) * s for i, s in zip(self.intervals, shares, strict=True)]
        tied, moved = self.region.tied, self.region.along_axes(shares)
        for k, by in zip(tied, moved, strict=True):
            i = self.intervals[k]
            found[k] = np.clip(i.nominal + self._half(i) * by, i.low, i.high)
        return {i.name: v for i, v in zip(self.intervals, found, strict=True)}

    def _half(self, i: Interval) -> float:
        """Half-width of an interval of standard errors where nothing cuts it off."""
        provenance = self.plant.parameters[i.name].provenance
        assert isinstance(i.origin, StandardErrors)
        assert isinstance(provenance, Fitted)
        return i.origin.count * (provenance.std_error or 0.0)

    def values(self, shares: Array) -> dict[str, Array]:
        """Parameters at places in the box; see `coordinates`."""
        found: dict[str, Array] = {}
        for i, value in zip(self.intervals, self.coordinates(shares).values(), strict=True):
            found |= {n: self.plant.values[n] * value for n in i.scaled} if i.scaled else {i.name: value}
        return found

    def at(self, shares: Array) -> Wrist:
        """The wrist at a place in the box, or, with `shares` of shape (intervals, lanes), its lanes.

        >>> from plants.parameters.files import built_in
        >>> box = box_of(built_in("flexion"))
        >>> float(box.at(np.full(len(box.names), 0.5)).Tw)
        0.16
        """
        values = self.values(shares)
        if self.remainder is None:
            return self.wrist.with_values(**values)
        met = replace(self.remainder, shift=values.pop(SHIFT))
        return self.wrist.with_values(**values) + met

    def leaving(self, left: ColouredRemainder | None) -> "Box":
        """The same box of wrists that meet this residual, or none."""
        own = tuple(i for i in self.intervals if i.name != SHIFT)
        part = () if left is None else (Interval(SHIFT, 0.0, 0.5, 1.0, "1", Given()),)
        return replace(self, intervals=(*own, *part), remainder=left)

    def loops(self) -> list[Wrist]:
        """The wrists at the corners of the box that the loop's parameters span, each of them apart from the
        others, which stay in the middle: at least all that the box holds."""
        own = {n for names in _together(self.plant).values() for n in names}
        ends = [(0.0, 1.0) if own & {i.name, *i.scaled} else (0.5,) for i in self.intervals]
        apart = replace(self, intervals=tuple(replace(i, origin=Given()) for i in self.intervals))
        return [apart.at(np.array(corner)) for corner in product(*ends)]

    def slopes(self, branch: str) -> tuple[float, float]:
        """Least and largest slope [deg/kPa] of a branch of the hysteresis in the box, with what a residual
        changes of it: a block of bounded gain beside the loop.

        >>> from plants.parameters.files import built_in
        >>> [round(s, 3) for s in box_of(built_in("flexion")).slopes("line1")]
        [0.324, 0.396]
        """
        found = [branch_slopes(wrist, wrist.reach)[branch] for wrist in self.loops()]
        share = 0.0 if self.remainder is None else float(self.remainder.steepest)
        return (1.0 - share) * min(found), (1.0 + share) * max(found)

    def bounds(self, name: str) -> tuple[float, float]:
        """Least and largest value of a parameter in the box; the plant's own where it is certain."""
        for i in self.intervals:
            if name == i.name:
                return i.low, i.high
            if name in i.scaled:
                return i.low * self.plant.values[name], i.high * self.plant.values[name]
        return self.plant.values[name], self.plant.values[name]


def box_of(
    plant: ParameterSet,
    spread: Spread | None = None,
    sigmas: float = SIGMAS,
    given: Mapping[str, tuple[float, float]] | None = None,
) -> Box:
    """The box of a parameter set: fitted parameters within `sigmas` standard errors, together where these are
    correlated, assumed ones (and the stated transit slope, which scales with the lines) within the shares
    of `spread`, those of `given` within the bounds given there; what is stated has no interval.  Where a loop
    at a corner would run backwards, which no rig's does, the intervals of standard errors are narrowed
    together, those of the loop, until none does.

    Raises InputError for an unknown name, an empty or inverted interval, one outside what the kind of
    parameter allows, and a box in which the loop runs backwards whatever is narrowed.
    """
    given = dict(given or {})
    unknown = [n for n in given if n not in plant.parameters]
    if unknown:
        raise InputError(f"box: no parameter {unknown[0]!r}; one of {', '.join(plant.parameters)}")
    shares = shares_of(plant, spread or Spread())
    together = _together(plant)
    found: list[Interval] = []
    groups: dict[str, tuple[str, ...]] = dict.fromkeys(TOGETHER, ())
    kinds, inner = plant.kinds, plant.law.roles(plant.parameters)["inner"]
    for name, p in plant.parameters.items():
        kind = kinds[name]
        if name in given:
            low, high = given[name]
            refuse_outside(name, low, high, kind.low, kind.high, p)
            found.append(Interval(name, low, p.value, high, p.unit, Given()))
            continue
        half, origin = half_width(name, p, shares, sigmas, name in inner)
        group = next((g for g, of in together.items() if name in of), None)
        if group and isinstance(origin, AssumedShare):
            groups[group] += (name,)
            continue
        low, high = max(p.value - half, kind.low), min(p.value + half, kind.high)
        if origin is not None and low < high:
            found.append(Interval(name, low, p.value, high, p.unit, origin))
    for group, names in groups.items():
        share = shares[names[0]] if names else 0.0
        if share > 0.0:
            origin = AssumedShare(share, names)
            found.append(Interval(group, 1.0 - share, 1.0, 1.0 + share, "1", origin, names))
    return _forwards(Box(plant, tuple(found)))


def _together(plant: ParameterSet) -> dict[str, tuple[str, ...]]:
    """Names of the parameters of each group."""
    roles = plant.law.roles(plant.parameters)
    return {group: tuple(n for role in of for n in roles[role]) for group, of in TOGETHER.items()}


def shares_of(plant: ParameterSet, spread: Spread) -> dict[str, float]:
    """The share of its value by which each parameter may differ that nobody measured, by name."""
    groups = _together(plant)
    slopes, widths = (
        dict.fromkeys(groups["slopes"], spread.slope),
        dict.fromkeys(groups["widths"], spread.width),
    )
    return slopes | widths | {"Tw": spread.lag} | dict.fromkeys(("k_fast", "k_slow", "e0"), RATES)


def _forwards(box: Box) -> Box:
    """The box, or the widest, in `NARROWED` steps of the loop's intervals, whose loops all run forwards."""
    own = {n for names in _together(box.plant).values() for n in names}
    for share in np.linspace(1.0, 0.0, NARROWED + 1):
        parts = [narrowed(i, float(share)) if own & {i.name, *i.scaled} else i for i in box.intervals]
        narrow = replace(box, intervals=tuple(i for i in parts if i.low < i.high))
        words = _backwards(narrow)
        if words is None:
            return narrow
    raise InputError(f"box: {words} at a corner of the box; give a smaller one")


def _backwards(box: Box) -> str | None:
    """How the loop runs backwards at a corner of the box, in words; None where it does not."""
    low, high = box.wrist.rig.pressure_range
    return next((w for w in (loop.hysteresis.problem(low, high) for loop in box.loops()) if w), None)
