"""The map of the gains: any level tells the truth at its points, and its lines run where limits are held."""

import numpy as np
import pytest

from design.synthesis.evaluate import evaluate
from design.tuner.case import case
from design.tuner.regions import ENDS, LEVELS, SIDE, finer, first, gains, outline, sharper
from design.tuner.setting import REGION, Setting
from plants import Wrist

SETTING = Setting(dead_time=0.02)


@pytest.fixture(scope="module")
def coarse():
    return case(Wrist.flexion(), SETTING).coarse


@pytest.fixture(scope="module")
def whole(coarse):
    known = first(coarse, REGION)
    while not known.complete:
        known = sharper(coarse, known, 97)
    return known


def test_levels_come_one_after_the_other_and_keep_what_is_known(coarse, whole):
    start = first(coarse, REGION)
    assert (start.level, start.done) == (LEVELS[0], ENDS[0])
    step = (SIDE - 1) // (LEVELS[0] - 1)
    for name, grid in start.excess.items():
        np.testing.assert_array_equal(grid[::step, ::step], whole.excess[name][::step, ::step])
    assert sharper(coarse, start, ENDS[1] - ENDS[0]).level == LEVELS[1]
    assert sharper(coarse, start, ENDS[1] - ENDS[0] - 1).level == LEVELS[0]
    assert (whole.level, whole.done) == (SIDE, SIDE**2)
    assert sharper(coarse, whole, 10) is whole


def test_without_time_there_is_no_level_yet(coarse):
    assert first(coarse, REGION, seconds=0.0).level == 0


def test_at_its_points_it_says_what_the_tuning_says(coarse, whole):
    Kp, Ki = (g.ravel() for g in np.meshgrid(*gains(REGION), indexing="ij"))
    drawn = np.random.default_rng(0).choice(Kp.size, 60, replace=False)
    at = evaluate(case(Wrist.flexion(), SETTING).problem, Kp[drawn], Ki[drawn])
    held = whole.worst.ravel()[drawn] <= 0.0
    assert 5 < held.sum() < 50
    np.testing.assert_array_equal(held, at.feasible)


def inside(rings, u, v):
    """Whether a point lies within rings, by the even-odd rule."""
    crossed = 0
    for ring in rings:
        (x, y), (x2, y2) = ring.T, np.roll(ring, -1, axis=0).T
        straddles = (y > v) != (y2 > v)
        with np.errstate(divide="ignore", invalid="ignore"):
            crossed += int(np.sum(straddles & (u < x + (v - y) / (y2 - y) * (x2 - x))))
    return crossed % 2 == 1


def test_what_is_coloured_holds_every_limit_but_for_a_narrow_edge(coarse, whole):
    rings = outline(whole).held
    u, v = np.random.default_rng(1).uniform(size=(2, 300))
    Kp, Ki = (low * (high / low) ** x for (low, high), x in ((REGION.Kp, u), (REGION.Ki, v)))
    at = evaluate(case(Wrist.flexion(), SETTING).problem, Kp, Ki)
    coloured = np.array([inside(rings, *p) for p in zip(u, v, strict=True)])
    clear = np.abs(at.worst_excess) > 0.1
    assert 50 < coloured.sum() < 250
    # A time of settling jumps where a run just does not settle, which blurs a cell of the map.
    assert np.mean(coloured[clear] != at.feasible[clear]) < 0.01


def test_a_line_runs_where_its_limit_is_just_held(whole):
    for line in outline(whole).limits["Ms"]:
        u, v = line[:: max(1, len(line) // 20)].T
        Kp, Ki = (low * (high / low) ** x for (low, high), x in ((REGION.Kp, u), (REGION.Ki, v)))
        at = evaluate(case(Wrist.flexion(), SETTING).problem, Kp, Ki)
        np.testing.assert_allclose(at.values["Ms"], 2.0, rtol=0.03)


def test_the_star_is_the_least_cost_of_what_holds(coarse, whole):
    Kp, Ki = whole.best
    at = evaluate(coarse, Kp, Ki)
    assert at.feasible[0]
    assert at.cost[0] == pytest.approx(whole.cost[whole.worst <= 0.0].min())


def test_between_points_it_is_bilinear():
    from scipy.interpolate import RegularGridInterpolator

    grid = np.random.default_rng(2).normal(size=(7, 7))
    at = np.linspace(0.0, 6.0, 19)
    there = RegularGridInterpolator((np.arange(7), np.arange(7)), grid)
    np.testing.assert_allclose(
        finer(grid), there(np.stack(np.meshgrid(at, at, indexing="ij"), -1)), atol=1e-12
    )
