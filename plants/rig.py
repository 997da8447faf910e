"""A rig: what a plant's motions have in common and its parameters do not say.

Units, range of the command, sample times, the task and its limits, and what may be different another day
are those of a rig, and stand in a TOML file; ``plants/parameters/wrist.toml``, the paper's wrist, shows the
format.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from math import isfinite
from pathlib import Path
from typing import Any

from plants.errors import InputError

FOLDER = Path(__file__).parent / "parameters"
BUILT_IN = FOLDER / "wrist.toml"


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
        """
        to = dict(zip(vars(written).values(), vars(self).values(), strict=True))
        parts = [to.get(part, part) for part in unit.replace("/", " / ").replace("(", "( ").split(" ")]
        return " ".join(parts).replace(" / ", "/").replace("( ", "(")


@dataclass(frozen=True)
class StepTask:
    """The task: size of the step [angle], half-width of the settling band as a share of it, duration of a
    run [s], how long the first angle of a return is held [s], pressures of the reaction curve."""

    step: float
    band: float
    duration: float
    hold: float
    reaction: tuple[float, float]


@dataclass(frozen=True)
class Uncertainty:
    """Shares by which parameters that nobody measured may differ: width of the loop, all its slopes
    together, lag of the joint, rates of the regulator; dead time [s] beside what was found, least and most;
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
class Rig:
    """A rig; limits: by name, as `design.synthesis.requirements.Limits`; sample times [s] of loop and log."""

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

    @property
    def record(self) -> dict[str, Any]:
        """The rig as in its TOML file."""
        t, u = self.task, self.uncertainty
        return {
            "name": self.name,
            "title": self.title,
            "motions": list(self.motions),
            "units": dict(vars(self.units)),
            "command": {"range": list(self.command_range)},
            "pressure": {"range": list(self.pressure_range)},
            "time": {"loop_s": self.sample_time, "log_s": self.log_time},
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


@cache
def built_in_rig() -> Rig:
    """The paper's wrist.

    >>> built_in_rig().command_range, built_in_rig().motions
    ((0.0, 4.0), ('flexion', 'deviation'))
    """
    return load_rig(BUILT_IN)


def load_rig(path: str | Path) -> Rig:
    """The rig of a TOML file; raises InputError as `parse_rig`, and for a file that cannot be read."""
    import tomllib

    try:
        content = tomllib.loads(Path(path).read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); give the .toml file of a rig") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: not valid TOML ({error}); see plants/parameters/wrist.toml") from None
    return parse_rig(content, str(path))


def parse_rig(table: Mapping[str, Any], where: str) -> Rig:
    """The rig of a table; `where` begins the errors.

    Raises InputError, in one line with the key, for one that is missing, unknown, of a wrong type or makes
    no sense.
    """
    of = _Reader(where)
    top = of.table(table, "rig", ("name", "title", "motions", *_TABLES))
    parts = {n: of.table(of.get(top, n, dict), n, keys) for n, keys in _TABLES.items()}
    motions = of.get(top, "motions", list)
    if not motions or not all(isinstance(m, str) and m for m in motions):
        raise InputError(f"{where}: motions must name one motion at least")
    units = Units(*(of.text(parts["units"], n) for n in _TABLES["units"]))
    task, sure = parts["task"], parts["uncertainty"]
    limits = {n: of.positive(parts["limits"], n) for n in parts["limits"]}
    return Rig(
        of.text(top, "name"),
        str(top.get("title", top["name"])),
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
    )  # fmt: skip


_DISTURBANCES = ("load", "noise", "resolution")

_TABLES: dict[str, tuple[str, ...]] = {
    "units": ("command", "pressure", "angle"),
    "command": ("range",),
    "pressure": ("range",),
    "time": ("loop_s", "log_s"),
    "task": ("step", "band", "duration_s", "hold_s", "reaction"),
    "limits": (
        "overshoot_percent", "Ms", "delay_margin_s", "total_variation_V", "steady_error_percent", "Mt",
        "settling_time_s",
    ),
    "uncertainty": ("width", "slope", "lag", "rates", "dead_time_s", *_DISTURBANCES),
}  # fmt: skip


@dataclass(frozen=True)
class _Reader:
    """Values of tables, with errors of one line that begin with where they stand."""

    where: str

    def table(self, table: Mapping[str, Any], name: str, known: tuple[str, ...]) -> Mapping[str, Any]:
        unknown = [k for k in table if k not in known]
        if unknown:
            raise InputError(
                f"{self.where}: {name}: unknown key {unknown[0]!r}; known are {', '.join(known)}"
            )
        return table

    def get(self, table: Mapping[str, Any], key: str, kind: type) -> Any:
        if not isinstance(table.get(key), kind):
            raise InputError(
                f"{self.where}: {key} is missing or no {kind.__name__}; see plants/parameters/wrist.toml"
            )
        return table[key]

    def text(self, table: Mapping[str, Any], key: str) -> str:
        found: str = self.get(table, key, str)
        return found

    def number(self, value: Any, key: str) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
            raise InputError(f"{self.where}: {key} = {value!r} is not a finite number")
        return float(value)

    def positive(self, table: Mapping[str, Any], key: str) -> float:
        found = self.number(table.get(key), key)
        if found <= 0.0:
            raise InputError(f"{self.where}: {key} = {found:g} must be positive")
        return found

    def not_negative(self, table: Mapping[str, Any], key: str) -> float:
        found = self.number(table.get(key, 0.0), key)
        if found < 0.0:
            raise InputError(f"{self.where}: {key} = {found:g} must not be negative")
        return found

    def share(self, table: Mapping[str, Any], key: str) -> float:
        found = self.number(table.get(key), key)
        if not 0.0 <= found < 1.0:
            raise InputError(f"{self.where}: {key} = {found:g} must be a share from 0 to below 1")
        return found

    def pair(self, table: Mapping[str, Any], key: str, equal: bool = False) -> tuple[float, float]:
        value = self.get(table, key, list)
        if len(value) != 2:
            raise InputError(f"{self.where}: {key} must be two numbers, lower and upper")
        low, high = self.number(value[0], key), self.number(value[1], key)
        if not (low < high or (equal and low == high)):
            raise InputError(f"{self.where}: {key} = {low:g}, {high:g}: the lower comes first")
        return low, high
