"""Exact arithmetic: polynomials on a window, bounds of a polynomial, whether a matrix is positive definite.

A float is a rational number, so that what a solver hands over can be checked without rounding.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, reduce
from math import comb, lcm, prod

import numpy as np
from numpy.typing import NDArray

Exact = NDArray[np.object_]
"""Array of fractions."""

FINE = 40
"""Degree to which a polynomial is raised before its coefficients bound it."""


def exact(values: object) -> Exact:
    """Floats as fractions, in an array of the same shape.

    >>> exact([0.5, 0.25]).tolist()
    [Fraction(1, 2), Fraction(1, 4)]
    """
    given = np.asarray(values, float)
    found = np.array([Fraction(float(x)) for x in given.ravel()], dtype=object).reshape(given.shape)
    return found


@dataclass(frozen=True)
class WindowPolynomials:
    """Polynomials p_j of degree j < count on i = 1 .. N, orthogonal there.

    first p_j(1), beyond p_j(N + 1), size mean_i p_j(i)^2, near 1, each (count,); shift T (count, count) with
    p_j(i + 1) = sum_l T_jl p_l(i).
    """

    samples: int
    first: Exact
    beyond: Exact
    size: Exact
    shift: Exact
    table: Exact


@cache
def window_polynomials(samples: int, count: int) -> WindowPolynomials:
    """The discrete Legendre polynomials of a window, as fractions (Abramowitz & Stegun, chapter 22).

    >>> p = window_polynomials(3, 2)
    >>> p.size[0], p.table[0].tolist() == [1, 1, 1, 1], sum(p.table[1][:3])
    (Fraction(1, 1), True, Fraction(0, 1))
    """
    at = [Fraction(i) for i in range(1, samples + 2)]
    rows: list[list[Fraction]] = []
    for degree in range(count):
        row = [x**degree for x in at]
        for other in rows:
            share = _mean(row, other, samples) / _mean(other, other, samples)
            row = [x - share * y for x, y in zip(row, other, strict=True)]
        rows.append(row)
    rows = [_near_one(row, samples) for row in rows]
    size = [_mean(row, row, samples) for row in rows]
    shift = [
        [_mean(row[1:], other, samples) / own for other, own in zip(rows, size, strict=True)] for row in rows
    ]
    of = np.array(rows, dtype=object).reshape(count, samples + 1)
    return WindowPolynomials(
        samples, of[:, 0], of[:, -1], np.array(size, dtype=object),
        np.array(shift, dtype=object).reshape(count, count), of,
    )  # fmt: skip


def _mean(a: Sequence[Fraction], b: Sequence[Fraction], samples: int) -> Fraction:
    return sum((x * y for x, y in zip(a[:samples], b[:samples], strict=True)), Fraction(0)) / samples


def _near_one(row: list[Fraction], samples: int) -> list[Fraction]:
    """A multiple whose mean square is near 1, by a factor with few digits."""
    factor = Fraction(1.0 / float(_mean(row, row, samples)) ** 0.5).limit_denominator(10**6)
    return [factor * x for x in row]


def range_on_unit(coefficients: Sequence[Fraction]) -> tuple[Fraction, Fraction]:
    """Bounds of sum_k c_k w^k for w from 0 to 1, by its coefficients in Bernstein's basis of a high degree.

    >>> low, high = range_on_unit([Fraction(0), Fraction(1), Fraction(-1)])      # w (1 - w)
    >>> low == 0, 0.25 <= high < 0.257
    (True, True)
    """
    n = max(FINE, len(coefficients) - 1)
    found = [
        sum((c * Fraction(comb(i, k), comb(n, k)) for k, c in enumerate(coefficients)), Fraction(0))
        for i in range(n + 1)
    ]
    return min(found), max(found)


def product(*matrices: Exact) -> Exact:
    """The product of matrices of fractions, each brought to whole numbers over one denominator first.

    A product of whole numbers needs no greatest common divisor; one of fractions spends most of its time on
    these.

    >>> product(exact([[0.5, 0.25]]), exact([[2.0], [1.0]])).tolist()
    [[Fraction(5, 4)]]
    """
    whole, below = zip(*map(_whole, matrices), strict=True)
    numbers, denominator = reduce(np.dot, whole), prod(below)
    found = np.array([Fraction(x, denominator) for x in numbers.ravel()], dtype=object)
    return found.reshape(numbers.shape)


def _whole(matrix: Exact) -> tuple[Exact, int]:
    """A matrix of fractions as one of whole numbers, and the denominator of all."""
    below = lcm(*(x.denominator for x in matrix.ravel()))
    whole = [x.numerator * (below // x.denominator) for x in matrix.ravel()]
    return np.array(whole, dtype=object).reshape(matrix.shape), below


def positive_definite(matrix: Exact) -> bool:
    """Whether a symmetric matrix of fractions is positive definite: every pivot of Gauss's elimination is
    positive, without any rounding.

    >>> [positive_definite(exact([[2.0, 1.0], [1.0, x]])) for x in (0.5, 0.51)]
    [False, True]
    """
    rows = [list(row) for row in matrix]
    n = len(rows)
    if any(rows[i][j] != rows[j][i] for i in range(n) for j in range(i)):
        return False
    for k in range(n):
        pivot = rows[k][k]
        if pivot <= 0:
            return False
        for i in range(k + 1, n):
            share = rows[i][k] / pivot
            for j in range(i, n):
                rows[i][j] -= share * rows[k][j]
                rows[j][i] = rows[i][j]
    return True
