"""Plants whose hysteresis is Prandtl-Ishlinskii, for tests of what goes through with any law."""

from dataclasses import replace
from pathlib import Path

from hypothesis import assume
from hypothesis import strategies as st

from plants import PrandtlIshlinskii
from plants.parameters.files import built_in, dump
from plants.parameters.quantities import Assumed, Parameter, ParameterSet, declared_kinds
from tests.laws.law_strategies import REST, between

LOOP = PrandtlIshlinskii(
    v0=0.08, v=(0.12, 0.09, 0.07), reach=34.0, span=9.0, b2=0.85, b1=0.9, c1=1.1, c2=1.05
)
"""About as wide and as steep as the paper's flexion; curved, its reversals rounded."""


def counted_from(loop: PrandtlIshlinskii, zero: float) -> PrandtlIshlinskii:
    """The same loop with an angle of 0 where it was `zero` [deg]: its rest pressure and centre have moved."""
    summed = loop.uncurved(zero)
    rest = loop.rest_pressure + summed / (loop.v0 + sum(loop.v))
    return replace(loop, rest_pressure=rest, centre=loop.centre - summed)


def second_law_set(loop: PrandtlIshlinskii = LOOP, axis: str = "flexion") -> ParameterSet:
    """The built-in wrist of a motion with another hysteresis."""
    base = built_in(axis)
    why = Assumed("made for a test")
    own = {
        n: Parameter(float(loop.values[n]), kind.unit, kind.low, kind.high, why)
        for n, kind in PrandtlIshlinskii.kinds(loop.values).items()
    }
    together = {**base.parameters, **own}
    names = declared_kinds(PrandtlIshlinskii, loop.values)
    return ParameterSet(axis, f"{axis} of plays", {n: together[n] for n in names})


def second_law_file(folder: Path) -> Path:
    """Its parameter set as a file."""
    path = folder / "plays.toml"
    dump(second_law_set(), path)
    return path


@st.composite
def sums_of_plays(draw: st.DrawFn) -> PrandtlIshlinskii:
    """Loops of one to four plays, some of no weight, and of any output curve."""
    v = tuple(draw(st.lists(between(0.0, 0.4), min_size=1, max_size=4)))
    assume(sum(v) > 0.02)
    curve = between(0.3, 3.0)
    return PrandtlIshlinskii(
        draw(between(0.0, 0.3)), v, draw(between(1.0, 40.0)), draw(between(1.0, 30.0)),
        draw(curve), draw(curve), draw(curve), draw(curve), REST, draw(between(-40.0, 40.0)),
    )  # fmt: skip
