"""Covers of all frequencies: ends of intervals, H-infinity norms, and a textbook loop of three parameters."""

import control
import numpy as np
import pytest

from design.robustness.certificates.constant import mu_sweep
from design.robustness.certificates.constant.mu import Block, quadratic, scalings, sizes, upper_bound
from design.robustness.certificates.constant.mu_sweep import SPARE, System, cover, crossings, piece

OMEGA = np.geomspace(1e-3, 1e4, 40_001)


def random_system(seed, blocks):
    rng = np.random.default_rng(seed)
    n = sum(b.size for b in blocks)
    A = rng.normal(size=(4, 4))
    A -= (np.linalg.eigvals(A).real.max() + 0.3) * np.eye(4)
    B, C = rng.normal(size=(4, n)), rng.normal(size=(n, 4))
    return System(A, B, C, 0.2 * rng.normal(size=(n, n)), blocks)


def gaston_safonov():
    """800 (1 + 0.1 d1) (s + 2) / (s (s + 4 + 0.2 d2) (s + 6 + 0.3 d3) (s + 10)) in unit feedback."""
    # States: integrator x1 <- 800 (1 + 0.1 d1) v; x2' = x1 - (4 + 0.2 d2) x2; x3' = x2 - (6 + 0.3 d3) x3;
    # compensator (s + 2)/(s + 10) = 1 - 8/(s + 10) on -x3: x4' = -x3 - 10 x4, v = -x3 - 8 x4.
    v = np.array([0.0, 0.0, -1.0, -8.0])
    A = np.array([800.0 * v, [1.0, -4.0, 0.0, 0.0], [0.0, 1.0, -6.0, 0.0], [0.0, 0.0, -1.0, -10.0]])
    B = np.zeros((4, 3))
    B[0, 0], B[1, 1], B[2, 2] = 1.0, -1.0, -1.0
    C = np.array([80.0 * v, [0.0, 0.2, 0.0, 0.0], [0.0, 0.0, 0.3, 0.0]])
    return System(A, B, C, np.zeros((3, 3)), (Block(),) * 3)


@pytest.mark.parametrize("seed", range(6))
def test_ends_of_intervals_are_where_a_dense_sweep_sees_the_inequality_end(seed):
    blocks = [(Block(), Block(), Block()), (Block(), Block("complex")), (Block("real", 2), Block("full", 2))]
    system = random_system(seed, blocks[seed % 3])
    response = system.response(OMEGA)
    ended = 0
    for at in (0.3, 1.0, 3.0):
        M = system.response(at)
        beta = 1.05 * upper_bound(M, system.blocks)[0]
        s = scalings(M, system.blocks, beta)
        N = sizes(system.blocks, beta)
        F = quadratic(response, s) - (1.0 - SPARE) * N[:, None] * s.D * N
        holds = np.linalg.eigvalsh(F)[:, -1] < 0.0
        found = piece(system, s, at, beta)
        # Every frequency inside holds, and the next one outside of a finite end does not.
        assert holds[(found.low <= OMEGA) & (found.high >= OMEGA)].all()
        if found.high < 1e3:
            i = np.searchsorted(OMEGA, found.high)
            assert not holds[i : i + 2].all()
            ended += 1
        if found.low > OMEGA[1]:
            i = np.searchsorted(OMEGA, found.low)
            assert not holds[i - 2 : i].all()
            ended += 1
        signs = np.linalg.slogdet(F)[0].real > 0.0
        flips = OMEGA[1:][signs[1:] != signs[:-1]]
        seen = crossings(system, s, at, beta)
        for omega in flips:  # a change of sign anywhere, far from `at` too
            assert np.min(np.abs(seen - omega)) < 1e-3 * omega
    assert ended > 0


@pytest.mark.parametrize("seed", range(3))
def test_a_complex_block_has_the_h_infinity_norm(seed):
    system = random_system(seed, (Block("full", 2),))
    norm = control.system_norm(control.ss(system.A, system.B, system.C, system.E), p="inf")
    found = cover(system, 0.5 * norm, step=0.002)
    assert found.complete
    assert norm < found.beta < 1.006 * norm
    assert found.margin >= 0.99 * SPARE


def test_a_narrow_resonance_between_grid_points_is_not_missed():
    damping = 1e-4  # peak of 1/(2 damping) at 1 rad/s, a share of 2e-4 wide
    A = np.array([[0.0, 1.0], [-1.0, -2.0 * damping]])
    system = System(
        A, np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]]), np.zeros((1, 1)), (Block("complex"),)
    )
    found = cover(system, 1.5)
    assert found.complete
    assert 1.0 / (2.0 * damping) <= found.beta < 1.02 / (2.0 * damping)
    assert found.peak == pytest.approx(1.0, rel=1e-3)


def test_one_real_parameter_has_the_gain_margin():
    loop = control.tf([1.0], [1.0, 3.0, 2.0, 0.0])  # stable up to a gain of 6
    closed = control.ss(control.feedback(loop, 2.0))
    # Gain 2 (1 + delta): unstable beyond delta = 2, and at -1, where the gain is 0.
    system = System(closed.A, closed.B, -2.0 * closed.C, -2.0 * closed.D, (Block(),))
    found = cover(system, 0.1)
    assert found.complete
    assert 1.0 <= found.beta < 1.02
    # With delta in 0 to 6, about a gain of 5: 6 is 1/5 above, 0 is 1 below.
    closed = control.ss(control.feedback(loop, 5.0))
    system = System(closed.A, closed.B, -5.0 * closed.C, -5.0 * closed.D, (Block(),))
    margin = control.margin(control.tf([5.0], [1.0, 3.0, 2.0, 0.0]))[0]
    found = cover(system, 0.1)
    assert found.complete
    assert 1.0 / (margin - 1.0) <= found.beta < 1.02 / (margin - 1.0)


def test_the_textbook_loop_of_de_gaston_and_safonov():
    # Exact calculation of the multiloop stability margin, IEEE TAC 33 (1988): the margin is 3.417.
    found = cover(gaston_safonov(), 0.1)
    assert found.complete
    assert found.beta == pytest.approx(1.0 / 3.417, rel=0.02)
    assert found.beta >= 1.0 / 3.4175


def test_a_cover_that_is_not_completed_says_so():
    system = random_system(0, (Block(), Block(), Block()))
    found = cover(system, 1e-3, most=3)
    assert not found.complete
    assert isinstance(found.reason, mu_sweep.Gap)


def test_a_wrong_interval_is_seen_by_the_check(monkeypatch):
    system = random_system(0, (Block(), Block(), Block()))
    monkeypatch.setattr(mu_sweep, "crossings", lambda *args: np.array([]))
    found = cover(system, upper_bound(system.response(0.0), system.blocks)[0] * 1.01)
    assert not found.complete
    assert isinstance(found.reason, mu_sweep.HoldsBarely)
