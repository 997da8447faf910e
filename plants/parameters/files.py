"""Parameter sets as TOML files: reading, with every mistake told in one line, and writing."""

from collections.abc import Mapping
from functools import cache
from math import inf, isinf
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plants.errors import InputError
from plants.hysteresis import LAWS, FourSegment, HysteresisLaw, with_values
from plants.parameters.correlation import parse_correlation
from plants.parameters.quantities import (
    Assumed,
    Fitted,
    Guessed,
    Learnt,
    Parameter,
    ParameterSet,
    Provenance,
    Stated,
    declared_kinds,
    in_units,
)
from plants.parameters.remainder import parse_remainders, remainder_table
from plants.parameters.spec import Kind
from plants.rig import Rig, built_in_rig, parse_rig
from plants.toml import Reader, check_keys, is_number, read_toml

if TYPE_CHECKING:
    from plants.effects.effect import Effect

EXAMPLE = "plants/parameters/flexion.toml"

KEYS = ("axis", "title", "hysteresis", "rig", "parameters", "effects", "remainder", "correlation")
"""What a parameter set says."""

OF_SCENARIOS = ("scenario", "controller", "metrics")
"""What a scenario file, which is a parameter set too, says beside."""

PROVENANCE = {
    "stated": ("source", "section"), "assumed": ("why",), "fitted": ("data", "std_error"),
    "learnt": ("data",),
}  # fmt: skip
"""What is said of each kind of evidence."""


@cache
def built_in(axis: str) -> ParameterSet:
    """The parameter set that ships with the project for one motion of the paper's wrist.

    >>> built_in("deviation").parameters["s"].provenance.section
    'section 5.2'
    """
    return load(Path(__file__).parent / f"{axis}.toml")


def load(path: str | Path) -> ParameterSet:
    """The parameter set of a TOML file.

    Raises InputError, in one line with the file, the effect and the parameter, for
    a file that is missing or no TOML, for an unknown or missing name or form, a
    wrong unit, a value outside its bounds, an unknown hysteresis law, or slopes and offsets that
    make the loop run backwards.
    """
    from plants.effects import in_order

    path = Path(path)
    text = read_toml(path, "parameter set", EXAMPLE)
    check_keys(text, (*KEYS, *OF_SCENARIOS), str(path))
    table = text.get("parameters")
    if not isinstance(table, dict) or not isinstance(text.get("axis"), str):
        raise InputError(f'{path}: needs axis = "..." and [parameters.NAME] tables, as {EXAMPLE}')
    of = Reader(str(path), EXAMPLE)
    axis = of.text(text, "axis")
    title = of.text(text, "title") if "title" in text else axis
    rig = parse_rig(of.get(text, "rig", dict), f"{path}: rig") if "rig" in text else built_in_rig()
    declared, of_paper = declared_kinds(_law(path, text), table), rig == built_in_rig()
    found = _parameters(
        f"{path}: ", table, {n: in_units(kind, rig) for n, kind in declared.items()}, of_paper
    )
    effects = list["type[Effect]"]()
    for form, own in _effects(path, text.get("effects", {})):
        where = f"{path}: effect {form.NAME!r}: "
        read_in = _parameters(
            where, own, {n: in_units(kind, rig) for n, kind in form.kinds().items()}, of_paper
        )
        found |= {f"{form.NAME}.{name}": p for name, p in read_in.items()}
        effects.append(form)
    left = parse_remainders(text.get("remainder", {}), str(path))
    together = parse_correlation(text.get("correlation", {}), found, str(path))
    result = ParameterSet(axis, title, found, in_order(effects), rig, left, together)
    _check_loop(path, result.values, rig)
    return result


def _law(path: Path, text: Mapping[str, Any]) -> type[HysteresisLaw]:
    """The hysteresis law that a file names, the paper's where it names none."""
    name = text.get("hysteresis", FourSegment.NAME)
    if not isinstance(name, str) or name not in LAWS:
        raise InputError(f"{path}: unknown hysteresis law {name!r}; known are {', '.join(LAWS)}")
    return LAWS[name]


def _effects(path: Path, table: Any) -> list[tuple["type[Effect]", Mapping[str, Any]]]:
    """The form of each effect of a file and its table of parameters."""
    from plants.effects import known_effects

    known = known_effects()
    if not isinstance(table, dict):
        raise InputError(f"{path}: effects must be [effects.NAME] tables; known are {', '.join(known)}")
    unknown = [n for n in table if n not in known]
    if unknown:
        raise InputError(f"{path}: unknown effect {unknown[0]!r}; known are {', '.join(known)}")
    found: list[tuple[type[Effect], Mapping[str, Any]]] = []
    for name in (n for n in known if n in table):
        entry, forms = table[name], {e.FORM: e for e in known[name]}
        own = entry.get("parameters") if isinstance(entry, dict) else None
        if not isinstance(own, dict):
            raise InputError(
                f'{path}: effect {name!r}: needs form = "..." and [effects.{name}.parameters.NAME] tables'
            )
        check_keys(entry, ("form", "parameters"), f"{path}: effect {name!r}")
        form = entry.get("form")
        if not isinstance(form, str) or form not in forms:
            ones = ", ".join(map(repr, forms))
            raise InputError(f"{path}: effect {name!r}: unknown form {form!r}; known are {ones}")
        found.append((forms[form], own))
    return found


def _parameters(
    where: str, table: Mapping[str, Any], kinds: Mapping[str, Kind], of_paper: bool
) -> dict[str, Parameter]:
    unknown = [n for n in table if n not in kinds]
    if unknown:
        raise InputError(f"{where}unknown parameter {unknown[0]!r}; known are {', '.join(kinds)}")
    missing = [n for n in kinds if n not in table]
    if missing:
        raise InputError(f"{where}parameter {missing[0]!r} is missing; all of {', '.join(kinds)} are needed")
    return {n: _parameter(f"{where}parameter {n!r}", kind, table[n], of_paper) for n, kind in kinds.items()}


def _parameter(where: str, kind: Kind, entry: Any, of_paper: bool) -> Parameter:
    """of_paper: whether the rig is the built-in one, whose bounds those of `kind` are; those of another rig
    stand in its file."""
    if not isinstance(entry, dict):
        raise InputError(f"{where}: needs value, unit and provenance")
    check_keys(entry, ("value", "unit", "bounds", "provenance"), where)
    value = entry.get("value")
    if not is_number(value):
        raise InputError(f"{where}: value {value!r} is not a finite number")
    if entry.get("unit") != kind.unit:
        raise InputError(f"{where}: unit {entry.get('unit')!r} is wrong; give the value in {kind.unit}")
    bounds = entry.get("bounds", [kind.low, kind.high])
    if not (isinstance(bounds, list) and len(bounds) == 2 and all(_is_bound(b) for b in bounds)):
        raise InputError(f"{where}: bounds must be two numbers, lower and upper")
    low, high = float(bounds[0]), float(bounds[1])
    if low > high:
        raise InputError(f"{where}: bounds {low:g} to {high:g}: the lower comes first")
    least, most = (kind.low, kind.high) if of_paper else (0.0 if kind.low >= 0.0 else -inf, inf)
    if not max(low, least) <= value <= min(high, most):
        low, high = max(low, least), min(high, most)
        raise InputError(f"{where}: value {value:g} is outside its bounds {low:g} to {high:g} {kind.unit}")
    return Parameter(float(value), kind.unit, low, high, _provenance(where, entry.get("provenance")))


def _is_bound(value: Any) -> bool:
    """Whether a value is a number, infinite where there is no bound."""
    return is_number(value) or (isinstance(value, float) and isinf(value))


def _provenance(where: str, entry: Any) -> Provenance:
    if isinstance(entry, dict) and isinstance(entry.get("kind"), str) and entry["kind"] in PROVENANCE:
        check_keys(entry, ("kind", *PROVENANCE[entry["kind"]]), f"{where}: provenance")
        error = entry.get("std_error", 0.0)
        if not is_number(error) or error < 0.0:
            raise InputError(
                f"{where}: std_error {error!r} is not a finite number, or is negative; leave it out "
                "where there is none"
            )
    match entry:
        case {"kind": "stated", "source": str(source), "section": str(section)}:
            return Stated(source, section)
        case {"kind": "assumed", "why": str(why)}:
            return Assumed(why)
        case {"kind": "guessed", "why": str(why)}:
            return Guessed(why)
        case {"kind": "fitted", "data": str(data), "std_error": int(error) | float(error)}:
            return Fitted(data, float(error))
        case {"kind": "fitted", "data": str(data)}:
            return Fitted(data, None)
        case {"kind": "learnt", "data": str(data)}:
            return Learnt(data)
    raise InputError(
        f'{where}: provenance must be {{kind="stated", source, section}}, {{kind="assumed", why}}, '
        '{kind="guessed", why}, {kind="fitted", data, std_error} or {kind="learnt", data}'
    )


def _check_loop(path: Path, values: Mapping[str, float], rig: Rig) -> None:
    loop = with_values(values)
    problem = loop.problem(*(v * values["gain"] for v in rig.command_range))
    if problem:
        roles = loop.roles(loop.values)
        names = [n for role in ("outer", "inner", "width") for n in roles[role]]
        raise InputError(f"{path}: {problem}; check {', '.join(names[:-1])} and {names[-1]}")


def dump(parameters: ParameterSet, path: str | Path) -> None:
    """Write a parameter set as TOML, complete or not at all; `load` gives it back to the last bit."""
    import tomlkit

    from plants.files import write_atomically

    document = tomlkit.document()
    document["axis"], document["title"] = parameters.axis, parameters.title
    document["hysteresis"] = parameters.law.NAME
    if parameters.rig != built_in_rig():
        document["rig"] = parameters.rig.record
    kinds, declared = parameters.kinds, tomlkit.table(is_super_table=True)
    of_wrist = declared_kinds(parameters.law, parameters.parameters)
    for name, p in parameters.parameters.items():
        if name in of_wrist:
            declared[name] = _entry(p, kinds[name])
    document["parameters"] = declared
    effects = tomlkit.table(is_super_table=True)
    for form in parameters.effects:
        table, own = tomlkit.table(), tomlkit.table(is_super_table=True)
        table["form"] = form.FORM
        for name in form.kinds():
            flat = f"{form.NAME}.{name}"
            own[name] = _entry(parameters.parameters[flat], kinds[flat])
        table["parameters"] = own
        effects[form.NAME] = table
    if parameters.effects:
        document["effects"] = effects
    if parameters.remainder:
        lefts = tomlkit.table(is_super_table=True)
        for channel, left in parameters.remainder.items():
            lefts[channel] = remainder_table(left)
        document["remainder"] = lefts
    if parameters.correlation:
        document["correlation"] = {n: dict(own) for n, own in parameters.correlation.items()}
    write_atomically(path, tomlkit.dumps(document))


def _entry(p: Parameter, kind: Kind) -> Any:
    """The table of a parameter, its meaning as a comment."""
    import tomlkit

    entry = tomlkit.table()
    entry.comment(kind.meaning)
    entry["value"], entry["unit"], entry["bounds"] = p.value, p.unit, [p.low, p.high]
    provenance = tomlkit.inline_table()
    provenance["kind"] = type(p.provenance).__name__.lower()
    provenance.update({k: v for k, v in vars(p.provenance).items() if v is not None})
    entry["provenance"] = provenance
    return entry
