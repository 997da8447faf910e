"""A rig: what a plant's motions have in common and its parameters do not say.

Units, range of the command, sample times, the task and its limits, and what may be different another day
are those of a rig, and stand in a TOML file; ``plants/parameters/wrist.toml``, the paper's wrist, shows the
format.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from plants.errors import InputError
from plants.toml import Reader, read_toml

FOLDER = Path(__file__).parent / "parameters"
BUILT_IN = FOLDER / "wrist.toml"
EXAMPLE = "plants/parameters/wrist.toml"

MOST_SAMPLES = 3_600_000
"""Samples in a run of the task: an hour at 1 ms."""


@dataclass(frozen=True)
class Units:
    """What command, pressure and angle of a rig are measured in."""

    command: str
    pressure: str
    angle: str

    def of(self, unit: str, written: "Units") -> str:
        """A unit written in the units of another rig, such as deg/kPa, in those of this one.

        >>> Units("V", "bar", "mm").of("deg/kPa", Units("V", "kPa", "deg"))
        'mm/bar'
        >>> Units("V", "bar", "mm").of("1/deg^2", Units("V", "kPa", "deg"))
        '1/mm^2'
        """
        to = dict(zip(vars(written).values(), vars(self).values(), strict=True))
        return re.sub(r"[^\s/()^]+", lambda part: to.get(part[0], part[0]), unit)

    def read_as(self, written: "Units") -> str:
        """What the units of another rig stand for in a text that is written in them, in words; empty where
        they are these.

        >>> Units("counts", "kPa", "mm").read_as(Units("V", "kPa", "deg"))
        'V stands for counts, deg for mm'
        """
        other = [
            (w, own) for w, own in zip(vars(written).values(), vars(self).values(), strict=True) if w != own
        ]
        return ", ".join(f"{w} {'for' if i else 'stands for'} {own}" for i, (w, own) in enumerate(other))


@dataclass(frozen=True)
class StepTask:
    """The task: size of the step [angle], half-width of the settling band as a share of it, duration of a
    run [s], how long the first angle of a return is held [s], and at most the reference before a step that is
    to begin calmly, pressures of the reaction curve."""

    step: float
    band: float
    duration: float
    hold: float
    reaction: tuple[float, float]


@dataclass(frozen=True)
class Uncertainty:
    """Shares by which parameters that nobody measured may differ: width of the loop, all its slopes
    together, lag of the joint, rates of the regulator; dead time [s], least and most, where none was found;
    load, a shift of the static angle to either side, noise of the sensor (standard deviation), resolution
    of the sensor [angle], each 0 where the file does not name it."""

    width: float
    slope: float
    lag: float
    rates: float
    dead_time: tuple[float, float]
    load: float = 0.0
    noise: float = 0.0
    resolution: float = 0.0


@dataclass(frozen=True)
class Zero:
    """What is logged where pressure and angle of the rig's plants are 0, as on a rig that bends to one side:
    its steps are made about the middle of its range; reversed: whether the logged angle falls as the
    pressure rises, where that of a plant rises; rest: angle of the plant at which the rig rests until it is
    moved first, where its initial curve begins: below 0 where the angle is counted from the middle."""

    pressure: float = 0.0
    angle: float = 0.0
    reversed: bool = False
    rest: float = 0.0

    def logged(self, angle: float) -> float:
        """An angle of the rig's plants [deg] as its log has it.

        >>> Zero(3.02, 26.0).logged(18.0), Zero(0.0, 26.0, True).logged(18.0)
        (44.0, 8.0)
        """
        return self.angle + (-angle if self.reversed else angle)

    def words(self, units: Units) -> str:
        """What is counted from where, in words; empty where all is counted from 0.

        >>> Zero(3.02, 26.0).words(Units("V", "kPa", "deg"))
        'the pressure from 3.02 kPa, the angle from 26 deg'
        >>> Zero(0.0, 26.0, True).words(Units("V", "kPa", "deg"))
        'the angle from 26 deg, with the opposite sign'
        """
        counted = (("pressure", self.pressure, units.pressure), ("angle", self.angle, units.angle))
        words = [f"the {what} from {value:.4g} {unit}" for what, value, unit in counted if value]
        if self.reversed:
            words.append("with the opposite sign" if self.angle else "the angle with the opposite sign")
        return ", ".join(words)


@dataclass(frozen=True)
class Rig:
    """A rig; limits: by name, as `design.synthesis.requirements.Limits`; sample times [s] of loop and log;
    zero: what its log is counted from; angle_delay: by how much later than the pressure its angle is read
    [s], by the sensor as far as is known, so that a controller reads it as late."""

    name: str
    title: str
    motions: tuple[str, ...]
    units: Units
    command_range: tuple[float, float]
    pressure_range: tuple[float, float]
    sample_time: float
    log_time: float
    task: StepTask
    limits: Mapping[str, float] = field(hash=False)
    uncertainty: Uncertainty
    zero: Zero = Zero()
    angle_delay: float = 0.0

    @property
    def rest_pressure(self) -> float:
        """Pressure of a motion at rest where nothing else says it: the middle of the range."""
        return 0.5 * (self.pressure_range[0] + self.pressure_range[1])

    @property
    def half_range(self) -> float:
        """Half the range of the pressure, by which effects measure how far a pressure is from rest.

        >>> built_in_rig().rest_pressure, built_in_rig().half_range
        (100.0, 100.0)
        """
        return 0.5 * (self.pressure_range[1] - self.pressure_range[0])

    def unit(self, written: str) -> str:
        """A unit that is written in those of the built-in rig, such as deg/kPa, in those of this one."""
        return self.units.of(written, built_in_rig().units) if written else written

    def scaled(self, value: float, unit: str) -> float:
        """A value [unit] of the built-in rig in the units of this one, where that has others: what was so
        large a share of command range, pressure range or step of the task is so here.

        >>> from dataclasses import replace
        >>> bender = replace(built_in_rig(), units=Units("V", "bar", "deg"), pressure_range=(0.0, 2.0))
        >>> round(bender.scaled(0.36, "deg/kPa"), 3), bender.scaled(5.0, "deg")
        (36.0, 5.0)
        """
        own = built_in_rig()
        sizes = (
            _span(self.command_range) / _span(own.command_range),
            self.half_range / own.half_range,
            self.task.step / own.task.step,
        )
        return value * _factor(unit, self.units, sizes)

    @property
    def record(self) -> dict[str, Any]:
        """The rig as in its TOML file."""
        t, u = self.task, self.uncertainty
        zero = {} if self.zero == Zero() else {"zero": dict(vars(self.zero))}
        late = {"angle_delay_s": self.angle_delay} if self.angle_delay else {}
        return {
            "name": self.name,
            "title": self.title,
            "motions": list(self.motions),
            "units": dict(vars(self.units)),
            **zero,
            "command": {"range": list(self.command_range)},
            "pressure": {"range": list(self.pressure_range)},
            "time": {"loop_s": self.sample_time, "log_s": self.log_time, **late},
            "task": {
                "step": t.step, "band": t.band, "duration_s": t.duration, "hold_s": t.hold,
                "reaction": list(t.reaction),
            },
            "limits": dict(self.limits),
            "uncertainty": {
                "width": u.width, "slope": u.slope, "lag": u.lag, "rates": u.rates,
                "dead_time_s": list(u.dead_time), "load": u.load, "noise": u.noise,
                "resolution": u.resolution,
            },
        }  # fmt: skip


def _span(ends: tuple[float, float]) -> float:
    return ends[1] - ends[0]


@cache
def _factor(unit: str, units: Units, sizes: tuple[float, float, float]) -> float:
    """What a value [unit] of the built-in rig is multiplied by in a rig of other units, whose command range,
    pressure range and step of the task are so many times those of the built-in one."""
    own = built_in_rig().units
    of = dict(zip(vars(own).values(), sizes, strict=True))
    factor, power = 1.0, 1.0
    for part in re.split(r"([/ ()]+)", unit):
        if "/" in part:
            power = -1.0
        named = part.strip("/ ()^2")
        if named in of and units.of(named, own) != named:
            factor *= of[named] ** (power * (2.0 if part.endswith("^2") else 1.0))
    return factor


@cache
def built_in_rig() -> Rig:
    """The paper's wrist.

    >>> built_in_rig().command_range, built_in_rig().motions
    ((0.0, 4.0), ('flexion', 'deviation'))
    """
    return load_rig(BUILT_IN)


def load_rig(path: str | Path) -> Rig:
    """The rig of a TOML file; raises InputError as `parse_rig`, and for a file that cannot be read."""
    return parse_rig(read_toml(path, "rig", EXAMPLE), str(path))


def parse_rig(table: Mapping[str, Any], where: str) -> Rig:
    """The rig of a table; `where` begins the errors.

    Raises InputError, in one line with the key, for one that is missing, unknown, of a wrong type or makes
    no sense.
    """
    of = Reader(where, EXAMPLE)
    top = of.table(table, "rig", ("name", "title", "motions", *_TABLES))
    parts = {
        n: of.table({} if n == "zero" and n not in top else of.get(top, n, dict), n, keys)
        for n, keys in _TABLES.items()
    }
    motions = of.get(top, "motions", list)
    if not motions or not all(isinstance(m, str) and m for m in motions):
        raise InputError(f"{where}: motions must name one motion at least")
    if len(set(motions)) < len(motions):
        raise InputError(f"{where}: motions names one twice")
    units = Units(*(of.text(parts["units"], n) for n in _TABLES["units"]))
    task, sure = parts["task"], parts["uncertainty"]
    samples = of.positive(task, "duration_s") / of.positive(parts["time"], "loop_s")
    if not 10 <= samples <= MOST_SAMPLES:
        raise InputError(f"{where}: duration_s is {samples:g} times loop_s; give 10 to {MOST_SAMPLES}")
    limits = {n: of.positive(parts["limits"], n) for n in parts["limits"]}
    return Rig(
        of.text(top, "name"),
        of.text(top, "title") if "title" in top else of.text(top, "name"),
        tuple(motions),
        units,
        of.pair(parts["command"], "range"),
        of.pair(parts["pressure"], "range"),
        of.positive(parts["time"], "loop_s"),
        of.positive(parts["time"], "log_s"),
        StepTask(
            of.positive(task, "step"),
            of.positive(task, "band"),
            of.positive(task, "duration_s"),
            of.positive(task, "hold_s"),
            of.pair(task, "reaction"),
        ),
        limits,
        Uncertainty(
            of.share(sure, "width"), of.share(sure, "slope"), of.share(sure, "lag"), of.share(sure, "rates"),
            of.pair(sure, "dead_time_s", True), *(of.not_negative(sure, n) for n in _DISTURBANCES),
        ),
        _zero(of, parts["zero"]),
        of.not_negative({"angle_delay_s": 0.0, **parts["time"]}, "angle_delay_s"),
    )  # fmt: skip


def _zero(of: Reader, table: Mapping[str, Any]) -> Zero:
    turned = of.get({"reversed": False, **table}, "reversed", bool)
    pressure, angle, rest = (of.number(table.get(n, 0.0), n) for n in ("pressure", "angle", "rest"))
    return Zero(pressure, angle, turned, rest)


_DISTURBANCES = ("load", "noise", "resolution")

_TABLES: dict[str, tuple[str, ...]] = {
    "units": ("command", "pressure", "angle"),
    "zero": ("pressure", "angle", "reversed", "rest"),
    "command": ("range",),
    "pressure": ("range",),
    "time": ("loop_s", "log_s", "angle_delay_s"),
    "task": ("step", "band", "duration_s", "hold_s", "reaction"),
    "limits": (
        "overshoot_percent", "Ms", "delay_margin_s", "total_variation_V", "steady_error_percent", "Mt",
        "settling_time_s",
    ),
    "uncertainty": ("width", "slope", "lag", "rates", "dead_time_s", *_DISTURBANCES),
}  # fmt: skip
