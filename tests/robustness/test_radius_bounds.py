"""Bounds of a joint spectral radius hold what is known of it between them."""

import numpy as np
import pytest

from design.robustness.certificates.sampled.lifted import radius_bounds


@pytest.mark.parametrize("degree", [-2, 0, 1, 3])
def test_a_form_has_an_even_degree(degree):
    with pytest.raises(ValueError, match="not an even number"):
        radius_bounds([np.eye(2)], degree)


@pytest.mark.parametrize("degree", [2, 4])
def test_of_one_matrix_it_is_the_spectral_radius(degree):
    matrix = np.array([[0.3, 2.0], [-0.1, 0.5]])
    found = radius_bounds([matrix], degree)
    exact = np.max(np.abs(np.linalg.eigvals(matrix)))
    assert found.lower == pytest.approx(exact, rel=1e-9)
    assert exact <= found.upper * (1.0 + 1e-9)
    assert found.upper == pytest.approx(exact, rel=0.02)


def test_of_matrices_that_commute_it_is_the_largest_of_theirs():
    found = radius_bounds([np.diag([0.9, 0.2]), np.diag([0.1, 0.7])], 2)
    assert (found.lower, found.upper) == pytest.approx((0.9, 0.9), rel=2e-3)
    assert found.lower <= found.upper


@pytest.mark.parametrize("seed", range(4))
def test_no_product_grows_beyond_the_upper_bound_and_the_word_grows_as_the_lower(seed):
    draw = np.random.default_rng(seed)
    matrices = [draw.normal(size=(2, 2)) * 0.6 for _ in range(2)]
    found = radius_bounds(matrices, 4, 6)
    assert found.lower <= found.upper * (1.0 + 1e-9)
    product = np.eye(2)
    for letter in found.word.letters:
        product = matrices[letter] @ product
    radius = np.max(np.abs(np.linalg.eigvals(product))) ** (1.0 / len(found.word.letters))
    assert found.lower == pytest.approx(radius)
    for _ in range(50):
        word, product = draw.integers(0, 2, 12), np.eye(2)
        for letter in word:
            product = matrices[letter] @ product
        assert np.max(np.abs(np.linalg.eigvals(product))) ** (1.0 / 12.0) <= found.upper * (1.0 + 1e-6)
    assert (
        found.upper <= found.lower * 3.0 ** (1.0 / 4.0) * 1.01
    )  # Parrilo & Jadbabaie's factor, n = 2, d = 2
