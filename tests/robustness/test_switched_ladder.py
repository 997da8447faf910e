"""The ladder for switched systems proves what is stable, as far as it should, and nothing else."""

import numpy as np
import pytest

from design.robustness.certificates.sampled.lifted import lifted, power, radius_bounds, ties
from design.robustness.certificates.sampled.quadratic import (
    best,
    common_margin,
    common_quadratic,
    definite,
    poly_margin,
    poly_quadratic,
    rounded,
    share_of_least,
)
from design.robustness.certificates.sampled.switched import Switched, continuous, discrete, scaled
from design.robustness.certificates.sampled.words import search_word


def dayawansa_martin(a: float) -> Switched:
    """Example of Dayawansa & Martin, IEEE TAC 44 (1999) 751: a common quadratic function exists for
    a below 3 + sqrt(8) = 5.828; stable under arbitrary switching beyond."""
    return continuous([np.array([[-1.0, -1.0], [1.0, -1.0]]), np.array([[-1.0, -a], [1.0 / a, -1.0]])])


def turn(a: float) -> float:
    """By how much the worst switching of that example stretches the plane in half a turn, from polar
    coordinates: r'/r and angle' of both modes, the mode with the larger d log r / d angle everywhere."""
    angle = np.linspace(0.0, np.pi, 200_001)
    u = np.array([np.cos(angle), np.sin(angle)])
    slopes = []
    for m in dayawansa_martin(a).generators:
        v = m @ u
        slopes.append(np.sum(u * v, axis=0) / (u[0] * v[1] - u[1] * v[0]))
    return float(np.exp(np.mean(np.max(slopes, axis=0)[:-1]) * np.pi))


def certified(system: Switched, degree: int) -> bool:
    return common_quadratic(lifted(rounded(system)[0], degree // 2))(0.0).holds


def test_a_common_quadratic_function_is_found_up_to_where_one_exists() -> None:
    limit = 3.0 + np.sqrt(8.0)
    assert certified(dayawansa_martin(0.998 * limit), 2)
    assert not certified(dayawansa_martin(1.002 * limit), 2)


def test_forms_certify_a_stable_system_without_common_quadratic_function() -> None:
    assert turn(8.0) < 1.0
    assert [certified(dayawansa_martin(8.0), d) for d in (2, 4)] == [False, True]
    # A higher rung reaches further, and none reaches beyond the exact limit.
    assert turn(9.6) < 1.0
    assert [certified(dayawansa_martin(9.6), d) for d in (4, 6)] == [False, True]


def test_no_rung_certifies_what_a_word_destabilises_though_every_part_is_stable() -> None:
    system = dayawansa_martin(13.0)
    assert np.all(system.fates > 0.0)
    assert turn(13.0) > 1.0
    assert not any(certified(system, d) for d in (2, 4, 6))
    word = search_word(system, 0.01, 5.0, letters=2)
    assert word.grows
    # One pass is half a turn.  No word stretches more than the worst one, and the fastest comes near it.
    assert 0.99 * turn(13.0) < word.radius < 1.0001 * turn(13.0)


@pytest.mark.slow
def test_discrete_system_that_only_later_rungs_certify() -> None:
    """Ando & Shih 1998, in Parrilo & Jadbabaie 2008, example 2.8: radius 1, quadratic bound sqrt(2)."""
    pair = [np.array([[1.0, 0.0], [1.0, 0.0]]), np.array([[0.0, 1.0], [0.0, -1.0]])]
    assert radius_bounds(pair, 2).upper == pytest.approx(np.sqrt(2.0), abs=1e-5)
    assert radius_bounds(pair, 4).upper == pytest.approx(1.0, abs=1e-3)
    slower = discrete([0.9 * a for a in pair])
    assert not common_quadratic(scaled(slower)[0])(0.0).holds
    assert certified(slower, 4)
    assert not certified(discrete([1.01 * a for a in pair]), 4)


def test_poly_quadratic_proves_more_than_quadratic_and_as_much_as_its_slack_form() -> None:
    """Against the slack form of Daafouz & Bernussou 2001, solved here as it is printed."""
    import cvxpy

    pair = [np.array([[1.0, 0.0], [1.0, 0.0]]), np.array([[0.0, 1.0], [0.0, -1.0]])]

    def slack(matrices: list[np.ndarray]) -> bool:
        t = cvxpy.Variable()
        s = [cvxpy.Variable((2, 2), symmetric=True) for _ in matrices]
        g = [cvxpy.Variable((2, 2)) for _ in matrices]
        rows = [t <= 1.0, *(x << np.eye(2) for x in s)]
        for i, a in enumerate(matrices):
            for j in range(len(matrices)):
                block = cvxpy.bmat([[g[i] + g[i].T - s[i], (a @ g[i]).T], [a @ g[i], s[j]]])
                rows.append((block + block.T) / 2 >> t * np.eye(4))
        cvxpy.Problem(cvxpy.Maximize(t), rows).solve(solver="CLARABEL")
        return float(t.value) > 1e-6

    verdicts = []
    for factor in (0.65, 0.75, 0.95, 1.05):
        matrices = [factor * a for a in pair]
        ours = poly_quadratic(discrete(matrices))(0.0).holds
        assert ours == slack(matrices)
        verdicts.append((common_quadratic(discrete(matrices))(0.0).holds, ours))
    assert verdicts == [(True, True), (False, True), (False, True), (False, False)]


def test_poly_quadratic_refuses_continuous_time() -> None:
    with pytest.raises(ValueError, match="sampled"):
        poly_quadratic(dayawansa_martin(2.0))


def test_best_rate_of_one_normal_matrix_is_that_of_its_eigenvalues() -> None:
    """One mode: the best decay is the spectral abscissa, or log of the spectral radius."""
    m = np.array([[-0.3, 2.0], [-2.0, -0.3]])
    for degree in (1, 2):
        system = lifted(continuous([m]), degree)
        found = best(common_quadratic(system), 1e-4, float(np.min(system.fates)), 20)
        assert found.rate == pytest.approx(0.3, rel=1e-4)
    sampled = discrete([np.array([[0.8, 0.3], [-0.3, 0.8]])], 0.1)
    found = best(common_quadratic(sampled), 1e-4, float(np.min(sampled.fates)), 20)
    assert found.rate == pytest.approx(-np.log(np.hypot(0.8, 0.3)) / 0.1, rel=1e-4)


def test_lift_is_a_norm_compatible_symmetric_power() -> None:
    rng = np.random.default_rng(3)
    a, b = rng.normal(size=(2, 3, 3))
    np.testing.assert_allclose(power(a @ b, 3), power(a, 3) @ power(b, 3), atol=1e-9)
    values = np.linalg.eigvals(power(a, 2))
    assert np.max(np.abs(values)) == pytest.approx(np.max(np.abs(np.linalg.eigvals(a))) ** 2)
    q, _ = np.linalg.qr(a)
    np.testing.assert_allclose(power(q, 3) @ power(q, 3).T, np.eye(10), atol=1e-12)


def test_ties_vanish_on_every_lifted_state() -> None:
    """And there are as many as quartic and sextic Gram matrices of three variables have: 6 and 27."""
    rng = np.random.default_rng(4)
    for degree, count in ((2, 6), (3, 27)):
        found = np.array(ties(3, degree))
        assert np.linalg.matrix_rank(found.reshape(len(found), -1)) == len(found) == count
        # x^[d] is the first column of the power of a matrix whose first column is x.
        for _ in range(5):
            z = power(np.outer(rng.normal(size=3), [1.0, 0.0, 0.0]), degree)[:, 0]
            np.testing.assert_allclose(z @ found @ z, 0.0, atol=1e-12)


def test_states_of_other_units_change_nothing() -> None:
    units = np.diag([1e3, 1e-2])
    system = dayawansa_martin(5.0)
    other = continuous([units @ m @ np.linalg.inv(units) for m in system.generators])
    rates = []
    for each in (system, other):
        even = scaled(each)[0]
        rates.append(best(common_quadratic(even), 1e-4, float(np.min(even.fates)), 16).rate)
    assert rates[0] == pytest.approx(rates[1], rel=1e-3)


@pytest.mark.parametrize("dt", [0.0, 0.1])
def test_the_check_of_a_common_function_ends_where_the_loss_of_a_turning_mode_does(dt: float) -> None:
    """Of |x|^2 under M = -a + b J a sample loses 2 a - dt (a^2 + b^2), whatever the state."""
    pair = tuple(np.array([[-a, b], [-b, -a]]) for a, b in ((0.5, 2.0), (0.8, 1.0)))
    system, exact = Switched(pair, dt), min(2 * 0.5 - dt * 4.25, 2 * 0.8 - dt * 1.64)
    assert common_margin(system, 3.0 * np.eye(2), exact - 1e-6) > 0.0
    assert common_margin(system, 3.0 * np.eye(2), exact + 1e-6) < 0.0
    assert common_margin(system, np.diag([1.0, 0.0]), -9.0) == common_margin(system, -np.eye(2), -9.0) == -1.0
    hull = Switched((pair[0], np.diag([-0.9, -0.9])), dt)
    assert common_margin(hull, np.eye(2), 0.9 * exact) > 0.0


def test_the_check_of_functions_that_follow_the_mode_ends_at_the_worst_pair() -> None:
    """Of p_i x^2 under x+ = a_i x a sample loses 1 - p_j a_i^2 / p_i before it goes on with any j."""
    factors, weights, dt = (0.9, 0.5), (1.0, 1.2), 0.2
    system = discrete([np.array([[a]]) for a in factors], dt)
    shapes = tuple(np.array([[p]]) for p in weights)
    exact = min(1.0 - q * a * a / p for a, p in zip(factors, weights, strict=True) for q in weights) / dt
    assert poly_margin(system, shapes, exact - 1e-6) > 0.0
    assert poly_margin(system, shapes, exact + 1e-6) < 0.0
    assert poly_margin(system, (shapes[0], 0.0 * shapes[1]), -9.0) == -1.0


def test_a_margin_is_the_least_eigenvalue_as_a_share_of_the_largest() -> None:
    turned = np.linalg.qr(np.random.default_rng(6).normal(size=(3, 3)))[0]
    matrix = turned @ np.diag([-0.5, 1.0, 2.0]) @ turned.T
    assert [share_of_least(c * matrix) for c in (1.0, 1e9)] == pytest.approx([-0.25, -0.25])
    assert share_of_least(np.zeros((2, 2))) == 0.0
    assert definite(np.diag([1e-11, 1.0]))
    assert not definite(np.diag([1e-13, 1.0]))
    assert not definite(matrix)
