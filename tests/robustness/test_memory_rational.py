"""Fractions: polynomials of a window, bounds on an interval, definiteness; each against floats."""

from fractions import Fraction

import numpy as np
import pytest

from design.robustness.certificates.memory.rational import (
    exact,
    positive_definite,
    product,
    range_on_unit,
    window_polynomials,
)


@pytest.mark.parametrize(("samples", "count"), [(1, 1), (7, 3), (50, 3)])
def test_polynomials_of_a_window_are_orthogonal_and_shift_into_each_other(samples: int, count: int) -> None:
    p = window_polynomials(samples, count)
    for j in range(count):
        for k in range(count):
            mean = sum(p.table[j, :samples] * p.table[k, :samples]) / samples
            assert mean == (p.size[j] if j == k else 0)
        assert abs(float(p.size[j]) - 1.0) < 1e-5
        for i in range(samples):
            assert p.table[j, i + 1] == sum(p.shift[j, k] * p.table[k, i] for k in range(count))
    assert p.first.tolist() == p.table[:, 0].tolist()
    assert p.beyond.tolist() == p.table[:, samples].tolist()


def test_bounds_of_a_polynomial_hold_and_are_near() -> None:
    random = np.random.default_rng(1)
    for _ in range(20):
        c = random.normal(size=5)
        w = np.linspace(0.0, 1.0, 2001)
        values = np.polynomial.polynomial.polyval(w, c)
        low, high = range_on_unit([Fraction(x) for x in c])
        assert float(low) <= values.min() + 1e-15
        assert float(high) >= values.max() - 1e-15
        assert float(high - low) <= 1.2 * np.ptp(values)


def test_definiteness_is_decided_where_floats_cannot() -> None:
    random = np.random.default_rng(2)
    a = random.normal(size=(6, 4))
    singular = exact(a).dot(exact(a).T)  # of rank 4, exactly
    hair = exact(1e-40 * np.eye(6))
    assert not positive_definite(singular)
    assert positive_definite(singular + hair)
    assert not positive_definite(singular - hair)
    assert not positive_definite(exact([[1.0, 0.5], [0.4, 1.0]]))


def test_a_matrix_that_is_not_symmetric_in_a_single_pair_is_refused() -> None:
    """Elimination looks at one of the two alone, so that it would call another matrix definite."""
    for i in range(4):
        for j in range(4):
            matrix = exact(2.0 * np.eye(4))
            matrix[i, j] += Fraction(1, 10**30)
            assert positive_definite(matrix) == (i == j)


def test_a_product_is_that_of_the_fractions_whatever_their_denominators() -> None:
    random = np.random.default_rng(3)
    a, b = exact(random.normal(size=(3, 5)) * 10.0 ** random.integers(-30, 30, (3, 5))), exact(np.eye(5))
    b[0, 4], b[2, 1] = Fraction(1, 3), Fraction(-7, 11)
    assert product(a, b, a.T).tolist() == a.dot(b).dot(a.T).tolist()
    assert product(a).tolist() == a.tolist()
