"""Words bound the joint spectral radius from below, and with forms from both sides."""

from itertools import product

import numpy as np
import pytest
from scipy.linalg import expm

from design.robustness.certificates.sampled.lifted import radius_bounds
from design.robustness.certificates.sampled.quadratic import common_margin, poly_margin
from design.robustness.certificates.sampled.switched import Switched, continuous, discrete
from design.robustness.certificates.sampled.words import _holder, discrete_word, necklaces, search_word

GOLDEN = [np.array([[1.0, 1.0], [0.0, 1.0]]), np.array([[1.0, 0.0], [1.0, 1.0]])]


def test_bounds_enclose_the_golden_ratio() -> None:
    bounds = radius_bounds(GOLDEN, 2)
    ratio = (1.0 + np.sqrt(5.0)) / 2.0
    assert bounds.lower == pytest.approx(ratio, rel=1e-12)
    assert bounds.upper == pytest.approx(ratio, rel=1e-6)
    assert bounds.lower <= bounds.upper
    assert bounds.word.letters == (0, 1)


@pytest.mark.slow
def test_radius_of_commuting_and_of_normal_matrices_is_the_largest_of_their_own() -> None:
    turned, _ = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))
    commuting = [turned @ np.diag(d) @ turned.T for d in ([0.9, -0.2, 0.1], [0.3, -0.95, 0.2])]
    other, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    normal = [commuting[0], other @ np.diag([0.5, -0.7, 0.1]) @ other.T]
    for matrices, radius in ((commuting, 0.95), (normal, 0.9)):
        bounds = radius_bounds(matrices, 2, length=4)
        assert bounds.lower == pytest.approx(radius, rel=1e-9)
        assert bounds.upper == pytest.approx(radius, rel=1e-5)


@pytest.mark.slow
def test_published_bounds_of_three_matrices() -> None:
    """Parrilo & Jadbabaie 2008, example 5.4: word 8.9149 (cut off), quadratic bound 9.761, quartic 8.92."""
    matrices = [
        np.array([[0.0, 1, 7, 4], [1, 6, -2, -3], [-1, -1, -2, -6], [3, 0, 9, 1]]),
        np.array([[-3.0, 3, 0, -2], [-2, 1, 4, 9], [4, -3, 1, 1], [1, -5, -1, -2]]),
        np.array([[1.0, 4, 5, 10], [0, 5, 1, -4], [0, -1, 4, 6], [-1, 5, 0, 1]]),
    ]
    quadratic, quartic = radius_bounds(matrices, 2, length=4), radius_bounds(matrices, 4, length=4)
    assert quadratic.lower == pytest.approx(8.91495, abs=5e-5)
    assert quadratic.word.letters == (0, 2)
    assert quadratic.upper == pytest.approx(9.761, abs=1e-3)
    assert quartic.upper == pytest.approx(8.92, abs=5e-3)


@pytest.mark.parametrize(("letters", "length"), [(2, 6), (3, 4), (4, 3)])
def test_necklaces_are_one_of_each_class_of_rotations(letters: int, length: int) -> None:
    words = product(range(letters), repeat=length)
    smallest = {min(w[k:] + w[:k] for k in range(length)) for w in words}
    assert sorted(smallest) == list(necklaces(letters, length))


@pytest.mark.parametrize("dt", [0.0, 0.002, 0.5])
def test_what_never_switches_grows_at_the_rate_of_its_own_pole(dt: float) -> None:
    """In continuous time and of any sample time [s]: poles at 0.7 +- 3i and -1 1/s."""
    m = np.array([[0.7, -3.0, 0.4], [3.0, 0.7, 0.0], [0.0, 0.0, -1.0]])
    system = discrete([expm(dt * m)], dt) if dt else continuous([m])
    word = search_word(system, 0.5, 2.0)
    assert word.letters == (0,)
    assert word.growth == pytest.approx(0.7)
    # Of x'x in the plane of the fast poles, a step or an instant: what it gains.
    gain = np.expm1(2.0 * 0.7 * dt) / dt if dt else 2.0 * 0.7
    assert system.fates == pytest.approx([-gain])
    assert system.rate(float(system.fates[0])) == pytest.approx(-0.7)


@pytest.mark.parametrize("dt", [0.0, 0.1])
def test_margins_are_the_same_in_any_coordinates(dt: float) -> None:
    draw = np.random.default_rng(2)
    modes = [-np.eye(3) + 0.2 * draw.normal(size=(3, 3)) for _ in range(2)]
    shapes = [np.eye(3), np.eye(3) + 0.02 * np.ones((3, 3))]
    t = np.diag([1.0, 3.0, 0.4]) @ (np.eye(3) + 0.3 * draw.normal(size=(3, 3)))
    turned = [np.linalg.inv(t) @ m @ t for m in modes]
    here, there = (
        discrete([np.eye(3) + dt * m for m in of], dt) if dt else continuous(of) for of in (modes, turned)
    )
    common = common_margin(here, shapes[0], 0.1)
    assert common > 0.0
    assert common_margin(there, t.T @ shapes[0] @ t, 0.1) == pytest.approx(common)
    if dt:
        several = poly_margin(here, tuple(shapes), 0.1)
        assert several > 0.0
        assert poly_margin(there, tuple(t.T @ p @ t for p in shapes), 0.1) == pytest.approx(several)


def test_powers_of_letters_are_found() -> None:
    """A pair whose best word holds a letter for two steps, by trying every word of up to eight."""
    a, b = np.array([[0.3, 1.2], [-1.1, 0.2]]), np.array([[1.0, 0.4], [0.0, 0.5]])
    every = []
    for n in range(1, 9):
        for w in product((a, b), repeat=n):
            total = np.linalg.multi_dot([*w, np.eye(2)]) if n > 1 else w[0]
            every.append(np.max(np.abs(np.linalg.eigvals(total))) ** (1.0 / n))
    word = discrete_word([a, b], 8)
    assert word.radius_per_time == pytest.approx(max(every), rel=1e-9)


def test_dwell_times_of_a_word_come_out_as_the_exact_ones() -> None:
    """Two turns along ellipses lying across each other: an even turn of one by a quarter, then of the
    other, multiplies by -diag(a^2, 1/a^2); each quarter takes pi/2 (Liberzon 2003, Switching in Systems
    and Control)."""
    a = 2.0
    spins = [np.array([[0.0, a], [-1.0 / a, 0.0]]), np.array([[0.0, 1.0 / a], [-a, 0.0]])]
    system = continuous([s - 0.3 * np.eye(2) for s in spins])
    word = search_word(system, 0.05, 4.0, letters=2)
    quarter = np.pi / 2.0
    exact = np.log(a**2) / (2.0 * quarter) - 0.3
    # The best dwell times grow no slower than quarters do, and are near to them.
    assert word.growth >= exact - 1e-9
    total = expm(word.dwells[1] * system.generators[word.letters[1]]) @ expm(
        word.dwells[0] * system.generators[word.letters[0]]
    )
    assert np.max(np.abs(np.linalg.eigvals(total))) == pytest.approx(word.radius, rel=1e-9)
    assert word.dwells[0] == pytest.approx(word.dwells[1], rel=0.05)


def test_sampled_words_hold_whole_samples_and_agree_with_continuous_ones() -> None:
    modes = [np.array([[-1.0, -1.0], [1.0, -1.0]]), np.array([[-1.0, -13.0], [1.0 / 13.0, -1.0]])]
    dt = 0.01
    sampled = search_word(discrete([expm(dt * m) for m in modes], dt), 0.05, 5.0, letters=2)
    free = search_word(continuous(modes), 0.05, 5.0, letters=2)
    assert all(abs(d / dt - round(d / dt)) < 1e-9 for d in sampled.dwells)
    assert sampled.growth == pytest.approx(free.growth, rel=0.02)
    assert sampled.growth <= free.growth + 1e-9
    assert free.grows


@pytest.mark.parametrize("longest", [1, 2, 3, 4, 5, 8, 9, 16, 17, 100])
def test_a_mode_that_is_held_for_whole_samples_is_a_power_of_its_matrix(longest: int) -> None:
    """Up to the longest that is asked for: by squaring, of which there have to be enough."""
    dt, generators = 0.01, (np.array([[-1.0, 3.0], [-2.0, 0.5]]), np.array([[0.2, -4.0], [1.0, -3.0]]))
    hold = _holder(Switched(generators, dt), longest * dt)
    steps = np.arange(1, longest + 1)
    for i, m in enumerate(generators):
        powers = [np.linalg.matrix_power(np.eye(2) + dt * m, k) for k in steps]
        np.testing.assert_allclose(hold(i, steps * dt), powers, rtol=1e-12)


def test_same_seed_same_word() -> None:
    system = continuous([np.array([[-1.0, -1.0], [1.0, -1.0]]), np.array([[-1.0, -9.0], [1.0 / 9.0, -1.0]])])
    first = search_word(system, 0.05, 5.0, letters=2, seed=5)
    assert first == search_word(system, 0.05, 5.0, letters=2, seed=5)
    assert not first.grows


@pytest.mark.slow
def test_words_of_eight_letters_are_tried_unless_told_otherwise() -> None:
    """Turns by a sixteenth of pi, and a projection that sees best what eight of them have turned."""
    angle, keeps, best = np.pi / 16.0, 0.999, 1.05
    turn = keeps * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    pair = [turn, best / keeps**8 * np.outer([1.0, 0.0], [0.0, 1.0])]  # 8 turns take its range to its sight
    of_eight = (best / keeps * np.cos(angle)) ** (1.0 / 8.0)
    assert radius_bounds(pair).lower == pytest.approx(of_eight, rel=1e-9)
    assert radius_bounds(pair, length=9).lower == pytest.approx(best ** (1.0 / 9.0), rel=1e-9)


def test_a_system_of_one_mode_has_a_word_of_one_letter() -> None:
    system = continuous([np.array([[-0.2, 1.0], [-1.0, -0.2]])])
    found = search_word(system, 0.1, 1.0, letters=1)
    assert set(found.letters) == {0}
    assert found.growth == pytest.approx(-0.2, abs=1e-9)  # the real part of its eigenvalues


def test_no_word_has_more_letters_than_asked_for() -> None:
    """Of two turns along ellipses lying across each other, either alone decays and both in turn grow."""
    spins = [np.array([[0.0, 2.0], [-0.5, 0.0]]), np.array([[0.0, 0.5], [-2.0, 0.0]])]
    system = continuous([s - 0.3 * np.eye(2) for s in spins])
    alone, both = (search_word(system, 0.05, 4.0, letters=n) for n in (1, 2))
    assert (len(alone.letters), len(both.letters)) == (1, 2)
    assert alone.growth == pytest.approx(-0.3)
    assert both.grows
