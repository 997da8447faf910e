"""Correlation of the errors of parameters that were estimated together."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plants.errors import InputError
from plants.toml import check_keys, is_number

Array = NDArray[np.float64]
Pairs = Mapping[str, Mapping[str, float]]
"""Correlation of a parameter, by name, with others by their names: each pair once."""

DIGITS = 4
"""To which correlations are written."""


@dataclass(frozen=True)
class ParameterCorrelation:
    """Correlation of the errors of parameters that were estimated together: matrix (n, n), in the order of
    their n names."""

    names: tuple[str, ...]
    matrix: Array

    def of(self, names: Iterable[str]) -> "ParameterCorrelation":
        """The same for some of the parameters."""
        wanted = set(names)
        kept = [i for i, n in enumerate(self.names) if n in wanted]
        return ParameterCorrelation(tuple(self.names[i] for i in kept), self.matrix[np.ix_(kept, kept)])

    @property
    def pairs(self) -> Pairs:
        """Each pair once, by the later of its names."""
        found: dict[str, dict[str, float]] = {}
        for i, name in enumerate(self.names):
            own = {n: round(float(self.matrix[i, j]), DIGITS) for j, n in enumerate(self.names[:i])}
            found |= {name: own} if own else {}
        return found


def all_pairs(found: Iterable[ParameterCorrelation]) -> Pairs:
    """The pairs of groups of parameters that were estimated one after the other."""
    return {n: own for c in found for n, own in c.pairs.items()}


def matrix_of(pairs: Pairs, names: Sequence[str]) -> Array:
    """The correlation matrix (n, n) of parameters in the order of their names: 0 for a pair that has none.

    >>> matrix_of({"w1": {"a1": 0.5}}, ["a1", "s", "w1"]).tolist()
    [[1.0, 0.0, 0.5], [0.0, 1.0, 0.0], [0.5, 0.0, 1.0]]
    """
    found = np.eye(len(names))
    at = {n: i for i, n in enumerate(names)}
    for name, own in pairs.items():
        for other, value in own.items():
            if name in at and other in at:
                found[at[name], at[other]] = found[at[other], at[name]] = value
    return found


def pairs_of(pairs: Pairs, names: Iterable[str]) -> Pairs:
    """The pairs of which both parameters are among those of some names."""
    wanted = set(names)
    found = {n: {o: v for o, v in own.items() if o in wanted} for n, own in pairs.items() if n in wanted}
    return {n: own for n, own in found.items() if own}


def parse_correlation(table: Any, names: Iterable[str], where: str) -> Pairs:
    """The pairs of the ``[correlation]`` table of a parameter set; `where` begins the errors.

    Raises InputError, in one line, for an unknown name, what is no number from -1 to 1, and for correlations
    that no errors can have together.
    """
    known = tuple(names)
    if not isinstance(table, dict) or not all(isinstance(own, dict) for own in table.values()):
        raise InputError(f"{where}: correlation must be [correlation.NAME] tables of numbers by name")
    check_keys(table, known, f"{where}: correlation")
    for name, own in table.items():
        check_keys(own, known, f"{where}: correlation.{name}")
        for other, value in own.items():
            if not is_number(value) or not -1.0 <= value <= 1.0 or other == name:
                raise InputError(f"{where}: correlation.{name}: {other} = {value!r} is no correlation")
    found = {n: {o: float(v) for o, v in own.items()} for n, own in table.items()}
    least = float(np.linalg.eigvalsh(matrix_of(found, known)).min())
    if least < -len(known) * 10.0**-DIGITS:
        raise InputError(f"{where}: correlation: no errors of parameters are correlated so; fit them again")
    return found
