"""Parameters that carry their evidence: value, unit, bounds and where the value comes from.

A parameter set is a TOML file; ``plants/parameters/flexion.toml`` shows the format.
A revised set has effects beside the declared wrist, whose parameters go by names
such as ``creep.gain``.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf
from typing import TYPE_CHECKING, Any

from plants.hysteresis import HysteresisLaw, law_of
from plants.parameters.correlation import Pairs
from plants.parameters.remainder import RemainderSize
from plants.parameters.spec import Kind
from plants.rig import Rig, built_in_rig

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
class Guessed(Assumed):
    """Read off a log roughly, so that a fit can start; nothing rests on it but where the fit began."""

    def __str__(self) -> str:
        return f"guessed from the log of {self.why}"


@dataclass(frozen=True)
class Fitted:
    """Estimated from data: which, and the standard error in the parameter's unit
    (None where the estimate lies at a bound)."""

    data: str
    std_error: float | None

    def __str__(self) -> str:
        error = "no standard error" if self.std_error is None else f"s.e. {self.std_error:.2g}"
        return f"fitted to {self.data}, {error}"


@dataclass(frozen=True)
class Learnt(Fitted):
    """Part of a map that was learnt from data: which; it has no cause and no standard error."""

    std_error: float | None = None

    def __str__(self) -> str:
        return f"learnt from {self.data}"


Provenance = Stated | Assumed | Fitted


REGULATOR: Mapping[str, Kind] = {
    "gain": Kind("kPa/V", "regulator, steady-state pressure per volt of command", 1.0, 1000.0),
    "k_fast": Kind("1/s", "regulator, rate far from the commanded pressure", 0.1, 100.0),
    "k_slow": Kind("1/s", "regulator, rate near the commanded pressure", 0.01, 100.0),
    "e0": Kind("kPa", "regulator, error at which the rate is half-way", 0.1, 200.0),
}
JOINT: Mapping[str, Kind] = {"Tw": Kind("s", "time constant of the wrist's lag", 0.005, 5.0)}


def declared_kinds(law: type[HysteresisLaw], names: Iterable[str] = ()) -> dict[str, Kind]:
    """The parameters of a declared wrist by name, in order: of the regulator, the hysteresis law and the
    joint; `names` are those that a set has, for a law whose number of parameters varies.

    >>> list(declared_kinds(law_of(["a1", "w1", "a2", "w2", "s", "rest_pressure"])))[4:]
    ['a1', 'w1', 'a2', 'w2', 's', 'rest_pressure', 'Tw']
    """
    return {**REGULATOR, **law.kinds(names), **JOINT}


def kinds_of(names: Iterable[str], effects: "Sequence[type[Effect]]" = ()) -> dict[str, Kind]:
    """Unit, meaning and bounds of the parameters of a wrist with these names: the declared wrist's, then
    those of its effects, such as ``creep.gain``.

    >>> from plants.effects import Creep
    >>> from plants.parameters.files import built_in
    >>> kinds_of(built_in("flexion").parameters, [Creep])["creep.time_constant"].unit
    's'
    """
    given = tuple(names)
    own = {f"{e.NAME}.{n}": kind for e in effects for n, kind in e.kinds().items()}
    return declared_kinds(law_of(given), given) | own


def in_units(kind: Kind, rig: Rig) -> Kind:
    """The kind of a parameter in the units of a rig.  Bounds are numbers of the paper's wrist: in other units
    all that is left of them is the sign."""
    unit = rig.unit(kind.unit)
    if unit == kind.unit:
        return kind
    return replace(kind, unit=unit, low=0.0 if kind.low >= 0.0 else -inf, high=inf)


REGULATOR_NAMES = tuple(REGULATOR)


def loop_names(names: Iterable[str], from_rest: bool = True) -> tuple[str, ...]:
    """The parameters of hysteresis law and joint that can be fitted, of a set with these names.

    The rest pressure is where a recording starts, and is not fitted; where recordings start anywhere
    (`from_rest` false) it is, if nothing else moves the loop as a whole.
    """
    given = tuple(names)
    law = law_of(given)
    shifts = law.SHIFTS and not from_rest
    return tuple(n for n in (*law.kinds(given), *JOINT) if n != "rest_pressure" or shifts)


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
    in a wrist; effects: the forms of the effects, in the order of `plants.effects.EFFECTS`; rig: whose
    motion it is; remainder: residual of the plant on held-out recordings, by channel (``angle_deg``,
    ``pressure_kPa``); correlation: of the errors of fitted parameters, each pair once.
    """

    axis: str
    title: str
    parameters: Mapping[str, Parameter]
    effects: tuple[type["Effect"], ...] = ()
    rig: Rig = field(default_factory=built_in_rig)
    remainder: Mapping[str, RemainderSize] = field(default_factory=dict)
    correlation: Pairs = field(default_factory=dict)

    @property
    def values(self) -> dict[str, float]:
        """Values by name."""
        return {name: p.value for name, p in self.parameters.items()}

    @property
    def law(self) -> type[HysteresisLaw]:
        """The hysteresis law."""
        return law_of(self.parameters)

    @property
    def kinds(self) -> dict[str, Kind]:
        """Unit, meaning and bounds of each parameter: of the declared wrist, then of the effects.

        >>> from plants.parameters.files import built_in
        >>> built_in("flexion").kinds["a1"].unit
        'deg/kPa'
        """
        declared = kinds_of(self.parameters, self.effects)
        return {n: in_units(kind, self.rig) for n, kind in declared.items()}

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
        kinds = self.kinds
        wide = {n: replace(p, low=kinds[n].low, high=kinds[n].high) for n, p in self.parameters.items()}
        return replace(self, parameters=wide)

    def within(
        self, bounds: Mapping[str, tuple[float, float]], values: Mapping[str, float]
    ) -> "ParameterSet":
        """The set with other bounds of some parameters, in their units, and starting values within them."""
        moved = {
            n: replace(self.parameters[n], value=min(max(values[n], low), high), low=low, high=high)
            for n, (low, high) in bounds.items()
        }
        return replace(self, parameters={**self.parameters, **moved})

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
                provenance=Learnt(data) if isinstance(p.provenance, Learnt) else Fitted(data, errors[name]),
            )  # fmt: skip
        title = f"{self.axis}, fitted to {data}"
        return replace(self, title=title, parameters=changed, remainder={}, correlation={})

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
        from plants.effects import in_order

        effects = in_order({e.NAME: e for e in (*self.effects, *forms)}.values())
        gone = {f"{f.NAME}." for f in forms}
        kept = {n: p for n, p in self.parameters.items() if not any(n.startswith(g) for g in gone)}
        added = {}
        for form in forms:
            for own, kind in form.kinds().items():
                name = f"{form.NAME}.{own}"
                origin = Learnt(data) if form.LEARNT else Fitted(data, None)
                added[name] = Parameter(float(values[name]), kind.unit, kind.low, kind.high, origin)
        # Declared parameters first, then those of the effects in their order.
        declared = declared_kinds(self.law, self.parameters)
        names = list(declared) + [f"{e.NAME}.{own}" for e in effects for own in e.kinds()]
        together = {**kept, **added}
        base = replace(self, parameters={n: together[n] for n in names if n in together}, effects=effects)
        found = base.fitted(values, {n: errors.get(n) for n in values}, data)
        words = f"{self.axis} with {', '.join(e.NAME for e in effects)}, fitted to {data}"
        return replace(found, title=title or (words if effects else found.title))
