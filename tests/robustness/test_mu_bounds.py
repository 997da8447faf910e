"""The upper bound of the mixed structured singular value, against cases with closed forms."""

from itertools import product

import numpy as np
import pytest
import scipy.optimize

from design.robustness.certificates.constant.mu import (
    Block,
    Scalings,
    balance,
    margin,
    proved,
    scalings,
    upper_bound,
)

REAL, COMPLEX = Block("real"), Block("complex")
RNG = np.random.default_rng(7)


def matrix(n):
    return RNG.normal(size=(n, n)) + 1j * RNG.normal(size=(n, n))


def bound(M, *blocks):
    value, found = upper_bound(M, blocks)
    # The claim again, by hand: the largest eigenvalue of the inequality at a beta slightly above.
    N = np.diag(np.concatenate([[1.0 if b.fixed else value * 1.0001 + 1e-12] * b.size for b in blocks]))
    F = M.conj().T @ found.D @ M + 1j * (found.G @ M - M.conj().T @ found.G) - N @ found.D @ N
    assert np.allclose(F, F.conj().T)
    assert np.linalg.eigvalsh(F)[-1] < 0.0
    return value


@pytest.mark.parametrize("value", [0.5, -3.0])
def test_one_real_parameter_on_a_real_gain_has_the_gain_itself(value):
    assert bound(np.array([[value + 0j]]), REAL) == pytest.approx(abs(value), rel=2e-3)


def test_one_real_parameter_on_an_imaginary_gain_does_nothing():
    assert bound(np.array([[2j]]), REAL) < 1e-2
    assert bound(np.array([[2j]]), COMPLEX) == pytest.approx(2.0, rel=2e-3)


@pytest.mark.parametrize("size", [2, 3, 4])
def test_a_full_block_has_the_largest_singular_value(size):
    M = matrix(size)
    assert bound(M, Block("full", size)) == pytest.approx(np.linalg.norm(M, 2), rel=2e-3)


@pytest.mark.parametrize("size", [2, 3])
def test_a_repeated_complex_scalar_has_the_spectral_radius(size):
    M = matrix(size)
    assert bound(M, Block("complex", size)) == pytest.approx(np.abs(np.linalg.eigvals(M)).max(), rel=3e-3)


def test_a_repeated_real_scalar_has_the_largest_real_eigenvalue():
    # Of a real matrix: the pair -4 +- 3j is larger than the real eigenvalue 2, and does not count.
    T = np.array([[1.0, 0.5, 0.0], [0.2, 1.0, -0.3], [0.1, 0.4, 1.0]])
    M = T @ np.array([[-4.0, 3.0, 0.0], [-3.0, -4.0, 0.0], [0.0, 0.0, 2.0]]) @ np.linalg.inv(T)
    # At a real matrix G is of little help, so that the bound may be as large as for a complex scalar, 5.
    assert 2.0 <= bound(M + 0j, Block("real", 3)) <= 5.0 * 1.003
    assert bound(np.diag([1j, 2j, 0.7]) + 0j, Block("real", 3)) == pytest.approx(0.7, rel=0.01)


@pytest.mark.parametrize("kinds", ["rrr", "rrrr", "rrc", "rccr"])
def test_matrices_of_rank_one_are_a_linear_program(kinds):
    # det(I - u v' Delta) = 1 - sum of a_i delta_i, a = conj(v) u; the bound is exact there (Young 1994).
    n = len(kinds)
    for _ in range(4):
        u, v = matrix(n)[0], matrix(n)[0]
        value = bound(np.outer(u, v.conj()), *(REAL if k == "r" else COMPLEX for k in kinds))
        a = u * v.conj()
        real, free = a[[k == "r" for k in kinds]], np.abs(a[[k == "c" for k in kinds]]).sum()

        def reach(size, real=real, free=free):  # how far the sum comes towards 1 with parameters up to size
            turns = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 20_001))
            # The sum ranges over a zonotope and a disc: it reaches 1 where every half plane does.
            edge = size * (np.abs(np.real(np.outer(turns.conj(), real))).sum(axis=1) + free)
            return np.min(edge - turns.real)

        radius = scipy.optimize.brentq(reach, 1e-3, 1e4)
        assert value == pytest.approx(1.0 / radius, rel=5e-3)


def test_three_complex_scalars_are_bounded_without_a_gap():
    # D scalings are exact for three complex blocks (Doyle 1982): mu = max over unitary U of rho(U M).
    M = matrix(3)
    turns = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 121))
    found = max(
        np.abs(np.linalg.eigvals(np.array([1.0, a, b])[:, None] * M)).max() for a, b in product(turns, turns)
    )
    assert found <= bound(M, COMPLEX, COMPLEX, COMPLEX) <= 1.005 * found


def test_a_mixed_bound_lies_between_what_a_search_finds_and_the_complex_bound():
    for _ in range(3):
        M = matrix(4)
        mixed, free = bound(M, REAL, REAL, COMPLEX, COMPLEX), bound(M, *[COMPLEX] * 4)
        found = 0.0
        for _ in range(4000):
            d = np.concatenate([RNG.uniform(-1, 1, 2), np.exp(2j * np.pi * RNG.random(2))])
            eigenvalues = np.linalg.eigvals(M * d)
            # I - M Delta is singular for delta = d / lambda, allowed where lambda is real.
            real = np.abs(eigenvalues.imag) < 1e-3 * np.abs(eigenvalues)
            found = max(found, np.max(np.abs(eigenvalues[real]), initial=0.0))
        assert found * 0.99 <= mixed <= free * 1.003


def test_a_block_of_fixed_size_is_skewed_mu():
    # [[0, b], [c, d]] with |delta_2| <= 1: delta_1 b (1 - d delta_2)^-1 delta_2 c = 1 at its largest.
    M = np.array([[0.0, 2.0], [3.0, 0.4]]) + 0j
    assert bound(M, COMPLEX, Block("complex", fixed=True)) == pytest.approx(6.0 / (1.0 - 0.4), rel=3e-3)
    assert upper_bound(np.array([[0.1, 2.0], [3.0, 1.4]]) + 0j, (REAL, Block("complex", fixed=True))) == (
        np.inf,
        None,
    )


def test_scaling_of_the_signals_does_not_matter():
    M, T = matrix(3), np.diag([1e-2, 1.0, 1e2])
    blocks = (REAL, REAL, COMPLEX)
    assert bound(T @ M @ np.linalg.inv(T), *blocks) == pytest.approx(bound(M, *blocks), rel=3e-3)


def test_no_scalings_where_beta_is_below_mu():
    M = np.diag([2.0, 0.5]) + 0j
    assert scalings(M, (REAL, REAL), 1.99) is None
    assert scalings(M, (REAL, REAL), 2.01) is not None


def test_the_margin_says_by_how_much_and_sees_a_wrong_proof():
    M, identity = np.diag([2.0, 0.5]) + 0j, np.eye(2) + 0j
    s = Scalings(identity, 0.0 * identity, "")
    assert margin(M, s, (REAL, REAL), 4.0) == pytest.approx(1.0 - 4.0 / 16.0)
    assert margin(M, s, (REAL, REAL), 1.0) == pytest.approx(-3.0)
    assert proved(M, s, (REAL, REAL)) == pytest.approx(2.0)
    assert margin(M, Scalings(-identity, 0.0 * identity, ""), (REAL, REAL), 4.0) == -np.inf


@pytest.mark.parametrize("sizes", [(1,), (2,), (1, 1), (2, 1), (1, 2, 1), (1, 1, 3, 1)])
def test_a_balanced_matrix_has_as_much_going_into_a_block_as_coming_out(sizes):
    """Of all blocks but the one itself, whatever the units were; one factor a block."""
    n, blocks = sum(sizes), tuple(Block("full", size) for size in sizes)
    of = np.repeat(np.arange(len(sizes)), sizes)
    units = 10.0 ** RNG.uniform(-1.0, 1.0, len(sizes))[of]
    M = units[:, None] * matrix(n) / units
    T = balance(M, blocks)
    assert T.shape == (n,)
    assert len(set(T.tolist())) == len(sizes)
    even = T[:, None] * M / T
    for k in range(len(sizes)):
        into, out = even[np.ix_(of == k, of != k)], even[np.ix_(of != k, of == k)]
        assert np.linalg.norm(into) == pytest.approx(np.linalg.norm(out), rel=1e-4)
