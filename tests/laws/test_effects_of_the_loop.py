"""Curved branches, softening and rate dependence bend the loop by their formulas."""

import numpy as np
import pytest

from plants.effects import (
    Bow,
    Mullins,
    Polynomial,
    PowerWidening,
    RememberedRate,
    SaturatingWidening,
    Saturation,
    SmoothCurve,
    SofteningByWork,
    Viscous,
    Warming,
)
from plants.effects.effect import Around
from plants.hysteresis import SIDES
from tests.laws.effect_steps import DT, WRIST, moved, ramp

UP = ramp(100.0, 190.0, rate=200.0)
LATE = UP > 140.0
"""Rows where the wrist is on line 1 for good."""
P = WRIST.hysteresis
X = UP - P.rest_pressure
SHARES = (0.05, -0.04, 0.03, 0.02, -0.01, 0.01)
"""Of Chebyshev polynomials of degree 2 to 7."""

WORN = 1 - np.exp(-X / 50.0)


def line1(x, a1=P.a1, w1=P.w1):
    return a1 * x - w1


@pytest.mark.parametrize(
    ("effect", "angle"),
    [
        (Polynomial(0.2, -0.15), line1(X + 100.0 * (X / 100) ** 2 * (0.2 - 0.15 * X / 100))),
        (Saturation(150.0), line1(150.0 * np.tanh(X / 150.0))),
        (Bow(-2.0, 2.0, 1.0), line1(X) - 2.0 * (X / 100) ** 2 + (X / 100) ** 3),
        (Viscous(0.01), line1(X) - 0.01 * 200.0),
        (SaturatingWidening(0.03, 100.0), line1(X) - 0.03 * 200.0 / (1.0 + 2.0)),
        (PowerWidening(1.0, 0.6), line1(X) - 2.0**0.6),
        (
            RememberedRate(0.02, 5000.0, 0.3),
            line1(X) - 0.02 * (r := 200.0 * (1 - np.exp(-X / 200.0 / 0.3))) / (1 + r / 5000.0),
        ),
        (SofteningByWork(0.1, 0.2, 1.0, 50.0), line1(X, P.a1 * (1 + 0.1 * WORN), P.w1 * (1 + 0.2 * WORN))),
        (Warming(0.1, 0.0, 1.0, 1.0), line1(X, P.a1 * (1 + 0.1 * (1 - np.exp(-X / 200.0))))),
        (Mullins(0.1, 0.0, 1.0, 30.0), line1(X, P.a1 * (1 + 0.1 * (1 - np.exp(-X / 30.0))))),
    ],
    ids=lambda v: v.FORM if hasattr(v, "FORM") else "",
)  # fmt: skip
def test_a_rising_pressure_follows_line_1_as_it_is_bent(effect, angle):
    h, _ = moved(WRIST + effect, UP)
    np.testing.assert_allclose(h[LATE], angle[LATE], atol=1e-9)


def test_one_curve_for_both_lines_is_a_sum_of_chebyshev_polynomials():
    path = ramp(100.0, 190.0, 20.0, rate=200.0)
    h, _ = moved(WRIST + SmoothCurve(*SHARES), path)
    x = (path - P.rest_pressure) / 100.0
    bend = np.polynomial.chebyshev.chebval(x, (0, 0, *SHARES)) - np.polynomial.chebyshev.chebval(
        0.0, (0, 0, *SHARES)
    )
    up, down = np.arange(len(path)) < 450, np.arange(len(path)) > 1000
    late = up & (path > 140.0)
    np.testing.assert_allclose(h[late], (line1(100.0 * x) + P.a1 * 100.0 * bend)[late], atol=1e-9)
    np.testing.assert_allclose(
        h[down], (P.a2 * 100.0 * x + P.w2 + P.a2 * 100.0 * bend)[down], atol=1e-9
    )  # fmt: skip


@pytest.mark.parametrize("way", [-1.0, 1.0])
def test_beyond_1_2_half_ranges_from_rest_one_curve_for_both_lines_bends_no_further(way):
    """Chebyshev polynomials grow without bound where they are not bound to an interval."""
    wrist = WRIST.with_values(rest_pressure=100.0 - way * 60.0)
    path = wrist.hysteresis.rest_pressure + way * np.linspace(0.0, 160.0, 1601)
    bent, plain = (moved(w, path)[0] for w in (wrist + SmoothCurve(*SHARES), wrist))
    bend = bent - plain
    np.testing.assert_allclose(bend[1200:], bend[1200], atol=1e-9)
    assert np.abs(np.diff(bend[1100:1200])).min() > 1e-4


@pytest.mark.parametrize("rest", [40.0, 100.0, 160.0])
def test_slopes_told_of_one_curve_for_both_lines_are_those_between_its_points(rest):
    wrist = WRIST.with_values(rest_pressure=rest)
    effect, loop = SmoothCurve(*SHARES), wrist.hysteresis
    for reach in ((0.0, 197.6), (10.0, 30.0), (170.0, 195.0)):
        pressures = np.linspace(*reach, 4001)
        _, bend, _, _ = effect.sampled(wrist, DT).bend((), pressures, pressures, loop, Around(0.0, 0.0))
        slopes = 1.0 + np.diff(bend) / np.diff(pressures) / P.a1
        told = effect.linear(wrist, np.ones(1), DT, reach).slopes
        assert set(told) == set(SIDES[:2])
        for slope in told.values():
            assert slope == pytest.approx((slopes.min(), slopes.max()), rel=1e-2)


def test_what_is_worked_stays_worked_on_the_way_back():
    path = ramp(100.0, 180.0, 20.0, rate=200.0)
    x = path[-1] - P.rest_pressure
    soft = {
        Mullins(0.1, 0.0, 1.0, 30.0): 80.0,  # the largest excursion
        SofteningByWork(0.1, 0.0, 1.0, 30.0): 240.0,  # the whole travel
    }
    for effect, amount in soft.items():
        h, _ = moved(WRIST + effect, path)
        slope = P.a2 * (1 + 0.1 * (1 - np.exp(-amount / 30.0)))
        assert h[-1] == pytest.approx(slope * x + P.w2, abs=1e-9)


def test_a_share_of_the_softening_goes_to_the_transit():
    wrist = WRIST + Warming(0.5, 0.0, 0.4, 1e-3)  # soft from the first sample on
    h, _ = moved(wrist, ramp(100.0, 180.0, 170.0))
    assert h[800] - h[-1] == pytest.approx(10.0 * P.s * (1.0 + 0.4 * 0.5), rel=1e-6)


def test_friction_forgets_a_rate_that_is_over():
    still = np.full(1000, 190.0)
    h, _ = moved(WRIST + Viscous(0.01), np.concatenate([UP, still]))
    assert h[len(UP) - 1] == pytest.approx(line1(90.0) - 2.0)
    assert h[-1] == pytest.approx(line1(90.0))
    slow, _ = moved(WRIST + RememberedRate(0.01, 5e3, 0.1), np.concatenate([UP, still]))
    remembered = 200.0 * (1 - np.exp(-0.45 / 0.1)) * np.exp(-np.array([100, 200]) * DT / 0.1)
    np.testing.assert_allclose(
        slow[len(UP) - 1 + np.array([100, 200])],
        line1(90.0) - 0.01 * remembered / (1 + remembered / 5e3), atol=1e-9,
    )  # fmt: skip
