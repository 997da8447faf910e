"""Parameters that carry their evidence: value, unit, bounds and where the value comes from.

A parameter set is a TOML file; ``plants/parameters/flexion.toml`` shows the format.
"""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from math import isfinite
from pathlib import Path
from typing import Any

from plants.errors import InputError


@dataclass(frozen=True)
class Stated:
    """The source says so: which source, and where in it."""

    source: str
    section: str

    def __str__(self) -> str:
        return f"stated, {self.source} {self.section}"


@dataclass(frozen=True)
class Assumed:
    """Nobody measured it: why this value is taken all the same."""

    why: str

    def __str__(self) -> str:
        return f"assumed: {self.why}"


@dataclass(frozen=True)
class Fitted:
    """Estimated from data: which, and the standard error in the parameter's unit
    (None where the estimate lies at a bound)."""

    data: str
    std_error: float | None

    def __str__(self) -> str:
        error = "no standard error" if self.std_error is None else f"s.e. {self.std_error:.2g}"
        return f"fitted to {self.data}, {error}"


Provenance = Stated | Assumed | Fitted


@dataclass(frozen=True)
class Kind:
    """What every parameter of a name has in common: unit, meaning, bounds that make sense."""

    unit: str
    meaning: str
    low: float
    high: float


KINDS: Mapping[str, Kind] = {
    "gain": Kind("kPa/V", "regulator, steady-state pressure per volt of command", 1.0, 1000.0),
    "k_fast": Kind("1/s", "regulator, rate far from the commanded pressure", 0.1, 100.0),
    "k_slow": Kind("1/s", "regulator, rate near the commanded pressure", 0.01, 100.0),
    "e0": Kind("kPa", "regulator, error at which the rate is half-way", 0.1, 200.0),
    "a1": Kind("deg/kPa", "slope of line 1 (plus direction)", 0.01, 5.0),
    "w1": Kind("deg", "offset of line 1 below the origin", 0.0, 60.0),
    "a2": Kind("deg/kPa", "slope of line 2 (minus direction)", 0.01, 5.0),
    "w2": Kind("deg", "offset of line 2 above the origin", 0.0, 60.0),
    "s": Kind("deg/kPa", "slope of the transit between the lines", 0.0, 5.0),
    "rest_pressure": Kind("kPa", "pressure at which the wrist starts and h = 0", -50.0, 500.0),
    "Tw": Kind("s", "time constant of the wrist's lag", 0.005, 5.0),
}
"""The parameters of the declared wrist, by name."""

REGULATOR_NAMES = ("gain", "k_fast", "k_slow", "e0")
WRIST_NAMES = ("a1", "w1", "a2", "w2", "s", "Tw")


@dataclass(frozen=True)
class Parameter:
    """A value [unit] within bounds, and its provenance."""

    value: float
    unit: str
    low: float
    high: float
    provenance: Provenance


@dataclass(frozen=True)
class ParameterSet:
    """All parameters of one motion of a wrist.

    axis: ``flexion``, ``deviation`` or a user's own name; title: one line for reports.
    """

    axis: str
    title: str
    parameters: Mapping[str, Parameter]
    effects: tuple[Any, ...] = ()

    @property
    def values(self) -> dict[str, float]:
        """Values by name."""
        return {name: p.value for name, p in self.parameters.items()}

    @property
    def record(self) -> dict[str, Any]:
        """``{name: {value, unit, provenance}}``, for JSON."""
        return {
            name: {
                "value": p.value,
                "unit": p.unit,
                "provenance": {"kind": type(p.provenance).__name__.lower(), **vars(p.provenance)},
            }
            for name, p in self.parameters.items()
        }

    @property
    def assumed(self) -> list[str]:
        """Names of the parameters that are assumed, not stated or fitted."""
        return [n for n, p in self.parameters.items() if isinstance(p.provenance, Assumed)]

    def unbounded(self) -> "ParameterSet":
        """The same set within the bounds of each kind of parameter, the widest that there are."""
        wide = {n: replace(p, low=KINDS[n].low, high=KINDS[n].high) for n, p in self.parameters.items()}
        return replace(self, parameters=wide)

    def fitted(
        self, values: Mapping[str, float], errors: Mapping[str, float | None], data: str
    ) -> "ParameterSet":
        """The same set with some values replaced by estimates from `data`.

        Bounds widen to hold the estimate, since they were only a guess of its range.
        """
        changed = dict(self.parameters)
        for name, value in values.items():
            p = changed[name]
            changed[name] = replace(
                p, value=float(value), low=min(p.low, float(value)), high=max(p.high, float(value)),
                provenance=Fitted(data, errors[name]),
            )  # fmt: skip
        return replace(self, title=f"{self.axis}, fitted to {data}", parameters=changed)


@cache
def built_in(axis: str) -> ParameterSet:
    """The parameter set that ships with the project for one motion of the paper's wrist.

    >>> built_in("deviation").parameters["s"].provenance.section
    'section 5.2'
    """
    return load(Path(__file__).parent / "parameters" / f"{axis}.toml")


def load(path: str | Path) -> ParameterSet:
    """The parameter set of a TOML file.

    Raises InputError, in one line with the file and the parameter, for a file
    that is missing or no TOML, for an unknown or missing name, a wrong unit, a
    value outside its bounds, or slopes and offsets that make the loop run backwards.
    """
    path = Path(path)
    try:
        text = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except FileNotFoundError:
        raise InputError(f"{path}: no such parameter set; give a .toml file that exists") from None
    except IsADirectoryError:
        raise InputError(f"{path}: is a folder; give the .toml file of a parameter set") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); give the .toml file of a set") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: not valid TOML ({error}); see plants/parameters/flexion.toml") from None
    table = text.get("parameters")
    if not isinstance(table, dict) or not isinstance(text.get("axis"), str):
        raise InputError(
            f'{path}: needs axis = "..." and [parameters.NAME] tables, as plants/parameters/flexion.toml'
        )
    unknown = [n for n in table if n not in KINDS]
    if unknown:
        raise InputError(f"{path}: unknown parameter {unknown[0]!r}; known are {', '.join(KINDS)}")
    missing = [n for n in KINDS if n not in table]
    if missing:
        raise InputError(f"{path}: parameter {missing[0]!r} is missing; all of {', '.join(KINDS)} are needed")
    found = {name: _parameter(path, name, table[name]) for name in KINDS}
    result = ParameterSet(text["axis"], str(text.get("title", text["axis"])), found)
    _check_loop(path, result.values)
    return result


def _parameter(path: Path, name: str, entry: Any) -> Parameter:
    where, kind = f"{path}: parameter {name!r}", KINDS[name]
    if not isinstance(entry, dict):
        raise InputError(f"{where}: needs value, unit and provenance")
    value = entry.get("value")
    if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
        raise InputError(f"{where}: value {value!r} is not a finite number")
    if entry.get("unit") != kind.unit:
        raise InputError(f"{where}: unit {entry.get('unit')!r} is wrong; give the value in {kind.unit}")
    bounds = entry.get("bounds", [kind.low, kind.high])
    if not (
        isinstance(bounds, list) and len(bounds) == 2 and all(isinstance(b, int | float) for b in bounds)
    ):
        raise InputError(f"{where}: bounds must be two numbers, lower and upper")
    low, high = float(bounds[0]), float(bounds[1])
    if not max(low, kind.low) <= value <= min(high, kind.high):
        low, high = max(low, kind.low), min(high, kind.high)
        raise InputError(f"{where}: value {value:g} is outside its bounds {low:g} to {high:g} {kind.unit}")
    return Parameter(float(value), kind.unit, low, high, _provenance(where, entry.get("provenance")))


def _provenance(where: str, entry: Any) -> Provenance:
    match entry:
        case {"kind": "stated", "source": str(source), "section": str(section)}:
            return Stated(source, section)
        case {"kind": "assumed", "why": str(why)}:
            return Assumed(why)
        case {"kind": "fitted", "data": str(data), "std_error": int(error) | float(error)}:
            return Fitted(data, float(error))
        case {"kind": "fitted", "data": str(data)}:
            return Fitted(data, None)
    raise InputError(
        f'{where}: provenance must be {{kind="stated", source, section}}, {{kind="assumed", why}} '
        'or {kind="fitted", data, std_error}'
    )


def loop_problem(v: Mapping[str, float], low: float = 0.0, high: float = 200.0) -> str | None:
    """Why the four segments make no loop between two pressures [kPa], or None if they do.

    >>> loop_problem(dict(a1=0.05, w1=6.0, a2=0.36, w2=6.0, s=0.08, rest_pressure=100.0))
    'transit slope s = 0.08 is not below a1 = 0.05, so the loop runs backwards'
    """
    for line in ("a1", "a2"):
        if not v["s"] < v[line]:
            return (
                f"transit slope s = {v['s']:g} is not below {line} = {v[line]:g}, so the loop runs backwards"
            )
    for pressure in (low, high):
        gap = (v["a2"] - v["a1"]) * (pressure - v["rest_pressure"]) + v["w1"] + v["w2"]
        if not gap > 0:
            return f"line 1 lies above line 2 at {pressure:g} kPa, so the loop runs backwards"
    return None


def _check_loop(path: Path, values: Mapping[str, float]) -> None:
    # The pressures that the command range reaches; the paper's own goes to 200 kPa.
    problem = loop_problem(values, 0.0, 4.0 * values["gain"])
    if problem:
        raise InputError(f"{path}: {problem}; check a1, a2, s, w1 and w2")


def dump(parameters: ParameterSet, path: str | Path) -> None:
    """Write a parameter set as TOML, complete or not at all."""
    import tomlkit

    from plants.files import write_atomically

    document = tomlkit.document()
    document["axis"], document["title"] = parameters.axis, parameters.title
    table = tomlkit.table(is_super_table=True)
    for name, p in parameters.parameters.items():
        entry = tomlkit.table()
        entry.comment(KINDS[name].meaning)
        entry["value"], entry["unit"], entry["bounds"] = p.value, p.unit, [p.low, p.high]
        provenance = tomlkit.inline_table()
        provenance["kind"] = type(p.provenance).__name__.lower()
        provenance.update({k: v for k, v in vars(p.provenance).items() if v is not None})
        entry["provenance"] = provenance
        table[name] = entry
    document["parameters"] = table
    write_atomically(path, tomlkit.dumps(document))
