"""The describing functions are backlash's known one, python-control's, and those of a plain sweep."""

import control
import numpy as np
import pytest

from design.robustness.predictions.describing_function import (
    backlash,
    centre_of,
    half_gap,
    hysteresis_function,
    regulator_function,
    regulator_rate,
    swept,
)
from plants import Wrist
from plants.hysteresis import FourSegment

LOOPS = {axis: getattr(Wrist, axis)().hysteresis for axis in ("flexion", "deviation")}
BACKLASH = FourSegment(a1=1.0, w1=2.0, a2=1.0, w2=2.0, s=0.0)
AMPLITUDES = [5.0, 15.0, 21.0, 23.0, 30.0, 45.0, 80.0]


class Plain:
    """The law of the one-page plant, apart from `plants.hysteresis`: pressure about a centre to angle."""

    def __init__(self, p: FourSegment, centre: float):
        self.p, self.x = p, centre - p.rest_pressure
        self.before = self.x
        self.h = 0.5 * ((p.a1 + p.a2) * self.x - p.w1 + p.w2)

    def __call__(self, dx):
        p, x = self.p, self.x + dx
        h = self.h + p.s * (x - self.before)
        self.h = max(min(h, p.a2 * x + p.w2), p.a1 * x - p.w1)
        self.before = x
        return self.h


def plain(p, centre, amplitude, points=2000):
    """Describing function and mean of the plain law by python-control's own quadrature."""
    (N,) = control.describing_function(Plain(p, centre), [amplitude], num_points=points, zero_check=False)
    law, cycle = Plain(p, centre), amplitude * np.sin(np.arange(points) * 2.0 * np.pi / points)
    for x in cycle:
        law(x)
    return complex(N), float(np.mean([law(x) for x in cycle]))


@pytest.mark.parametrize("ratio", [1.01, 1.5, 2.0, 3.0, 10.0, 100.0])
def test_backlash_has_the_function_of_the_textbook_and_of_python_control(ratio):
    b, A = 0.7, 0.7 * ratio
    theirs = control.friction_backlash_nonlinearity(2.0 * b).describing_function(A)
    assert complex(backlash(b, A)) == pytest.approx(complex(theirs), abs=1e-12)
    # Slotine & Li 1991, section 5.3 (b1, a1 over A), with their b = half gap and slope 1.
    a1 = 4.0 * b / np.pi * (b / A - 1.0)
    c = 2.0 * b / A - 1.0
    b1 = A / np.pi * (np.pi / 2.0 - np.arcsin(c) - c * np.sqrt(1.0 - c**2))
    assert complex(backlash(b, A)) == pytest.approx(complex(b1, a1) / A, abs=1e-12)


def test_a_gap_that_is_not_crossed_passes_nothing():
    np.testing.assert_array_equal(backlash(1.0, [0.2, 0.9, 1.0]), 0.0)


def test_the_loop_without_transit_slope_is_backlash():
    A = np.array([1.0, 2.5, 4.0, 20.0])
    N, mean = hysteresis_function(BACKLASH, A)
    theirs = [control.friction_backlash_nonlinearity(4.0).describing_function(a) for a in A]
    np.testing.assert_allclose(N, theirs, atol=1e-12)
    np.testing.assert_allclose(mean, 0.0, atol=1e-12)


def test_parallel_lines_are_backlash_beside_the_transit_whatever_the_centre():
    p = LOOPS["flexion"]
    A, b = np.array(AMPLITUDES), half_gap(p)
    theirs = np.array([control.friction_backlash_nonlinearity(2.0 * b).describing_function(a) for a in A])
    for centre in (60.0, 100.0, 137.0):
        N, mean = hysteresis_function(p, A, centre)
        np.testing.assert_allclose(N, p.s + (p.a1 - p.s) * theirs, atol=1e-12)
        np.testing.assert_allclose(mean, p.a1 * (centre - 100.0), atol=1e-9)


@pytest.mark.parametrize("axis", LOOPS)
@pytest.mark.parametrize("centre", [100.0, 112.0])
def test_it_is_python_controls_quadrature_of_the_plain_law(axis, centre):
    for A in AMPLITUDES:
        N, mean = hysteresis_function(LOOPS[axis], A, centre)
        theirs, plain_mean = plain(LOOPS[axis], centre, A)
        assert complex(N[0]) == pytest.approx(theirs, abs=3e-5)
        assert float(mean[0]) == pytest.approx(plain_mean, abs=3e-3)


def test_a_sweep_with_the_simulators_law_has_the_same_harmonic():
    A = np.array(AMPLITUDES)
    _, h = swept(LOOPS["deviation"], A, 110.0)
    turn = np.linspace(0.0, 2.0 * np.pi, len(h))[:-1]
    harmonic = 2.0 * np.mean(h[:-1] * (np.sin(turn) + 1j * np.cos(turn))[:, None], axis=0) / A
    np.testing.assert_allclose(hysteresis_function(LOOPS["deviation"], A, 110.0)[0], harmonic, atol=2e-5)
    np.testing.assert_allclose(h[0], h[-1], atol=1e-9)  # the cycle closes


@pytest.mark.parametrize("axis", LOOPS)
@pytest.mark.parametrize("angle", [-8.0, 0.0, 8.0])
def test_about_the_centre_that_is_found_the_plain_law_has_the_mean_that_was_asked_for(axis, angle):
    for A in (23.0, 45.0):
        centre = float(centre_of(LOOPS[axis], A, angle)[0])
        assert plain(LOOPS[axis], centre, A)[1] == pytest.approx(angle, abs=5e-3)


@pytest.mark.parametrize("E", [0.01, 3.0, 9.0, 30.0, 300.0])
def test_the_regulators_function_is_python_controls_quadrature_of_its_law(E):
    p = Wrist.flexion().regulator

    def flow(e):
        return (p.k_slow + (p.k_fast - p.k_slow) * e**2 / (e**2 + p.e0**2)) * e

    theirs = complex(control.describing_function(flow, [E], num_points=20_000)[0])
    assert float(regulator_function(p, E)) == pytest.approx(theirs.real, rel=1e-9)
    assert abs(theirs.imag) < 1e-9
    assert float(regulator_rate(p, regulator_function(p, E) * E)) == pytest.approx(theirs.real, rel=1e-8)


def test_a_regulator_of_one_rate_keeps_it():
    p = Wrist.flexion().with_values(k_slow=9.0).regulator
    np.testing.assert_allclose(regulator_rate(p, [1e-3, 1.0, 1e3]), 9.0)
