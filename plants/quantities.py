"""Parameters that carry their evidence: value, unit, bounds and where the value comes from.

A parameter set is a TOML file; ``plants/parameters/flexion.toml`` shows the format.
A revised set has effects beside the declared wrist, whose parameters go by names
such as ``creep.gain``.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from plants.effects.effect import Effect  # which takes its `Kind` from here


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


def kind_of(name: str, effects: "Sequence[type[Effect]]" = ()) -> Kind:
    """The kind of a parameter of the declared wrist, or, such as ``creep.gain``, of one of its effects.

    Raises KeyError for a name that neither has.

    >>> from plants.effects import Creep
    >>> kind_of("a1").unit, kind_of("creep.time_constant", [Creep]).unit
    ('deg/kPa', 's')
    """
    if name in KINDS:
        return KINDS[name]
    phenomenon, _, own = name.partition(".")
    for effect in effects:
        if phenomenon == effect.NAME:
            return effect.kinds()[own]
    raise KeyError(name)


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

    axis: ``flexion``, ``deviation`` or a user's own name; title: one line for
    reports; parameters: of the declared wrist, then of the effects, by their names
    in a wrist; effects: the forms of the effects, in the order of `plants.effects.EFFECTS`.
    """

    axis: str
    title: str
    parameters: Mapping[str, Parameter]
    effects: tuple[type["Effect"], ...] = ()

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
        kinds = {n: kind_of(n, self.effects) for n in self.parameters}
        wide = {n: replace(p, low=kinds[n].low, high=kinds[n].high) for n, p in self.parameters.items()}
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

    def revised(
        self,
        forms: "Sequence[type[Effect]]",
        values: Mapping[str, float],
        errors: Mapping[str, float | None],
        data: str,
        title: str | None = None,
    ) -> "ParameterSet":
        """The same set with effects added, all `values` being estimates from `data`.

        `values` holds every parameter of the effects and those of the declared wrist
        that were fitted; `errors` their standard errors, None or no entry for one
        without.  An effect that the set has already is replaced.  Raises KeyError for
        a parameter of an effect without a value, or a value that is nobody's.
        """
        from plants.effects import EFFECTS

        chosen = {e.NAME: e for e in (*self.effects, *forms)}
        effects = tuple(chosen[n] for n in EFFECTS if n in chosen)
        gone = {f"{f.NAME}." for f in forms}
        kept = {n: p for n, p in self.parameters.items() if not any(n.startswith(g) for g in gone)}
        added = {}
        for form in forms:
            for own, kind in form.kinds().items():
                name = f"{form.NAME}.{own}"
                added[name] = Parameter(
                    float(values[name]), kind.unit, kind.low, kind.high, Fitted(data, None)
                )
        # Declared parameters first, then those of the effects in their order.
        names = list(KINDS) + [f"{e.NAME}.{own}" for e in effects for own in e.kinds()]
        together = {**kept, **added}
        base = replace(self, parameters={n: together[n] for n in names if n in together}, effects=effects)
        found = base.fitted(values, {n: errors.get(n) for n in values}, data)
        words = f"{self.axis} with {', '.join(e.NAME for e in effects)}, fitted to {data}"
        return replace(found, title=title or (words if effects else found.title))


@cache
def built_in(axis: str) -> ParameterSet:
    """The parameter set that ships with the project for one motion of the paper's wrist.

    >>> built_in("deviation").parameters["s"].provenance.section
    'section 5.2'
    """
    return load(Path(__file__).parent / "parameters" / f"{axis}.toml")


def load(path: str | Path) -> ParameterSet:
    """The parameter set of a TOML file; see `plants.parameter_files.read` for what is refused."""
    from plants.parameter_files import read

    return read(path)


def dump(parameters: ParameterSet, path: str | Path) -> None:
    """Write a parameter set as TOML, complete or not at all; `load` gives it back to the last bit."""
    from plants.parameter_files import write

    write(parameters, path)


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
