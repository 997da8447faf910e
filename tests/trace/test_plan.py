"""`wrist plan`: the recording that is planned tells more than a staircase of its length, within the range of
the command."""

from dataclasses import replace

import numpy as np
import pytest

from plants.effects import Creep
from plants.effects.wrist.branch_curvature import Polynomial
from plants.measured.trace.plan import (
    KINDS,
    Rival,
    _answers,
    chance,
    distance,
    made,
    plan,
    shrinks,
    staircase,
)
from plants.wrist import Wrist

NOISE = 0.07
NAMES = ("a1", "w1", "a2", "w2", "s", "Tw")
TIME = np.arange(20_000) * 0.001


def tied(one, two, names):
    """Two models, of whose parameters 5 % is known."""
    known = np.diag([(0.05 * two.values[n]) ** -2.0 for n in names])
    return Rival("one", "two", one, two, "angle_deg", NOISE, names, known)


@pytest.fixture(scope="module")
def rivals():
    plain = Wrist.flexion()
    return tied(plain + Creep(gain=0.02, time_constant=3.0), plain, NAMES), tied(plain, plain, NAMES)


def test_the_plan_tells_more_than_a_staircase_within_the_range(rivals):
    tie, own = rivals
    found = plan([tie], [own], 20.0, seed=1, tried=6)
    assert found.planned[0] > found.staircase_distance[0]
    assert chance(found.planned[0]) < chance(found.staircase_distance[0])
    low, high = Wrist.flexion().rig.command_range
    assert low <= found.command.min() < found.command.max() <= high
    assert found.command.size == TIME.size
    rest = 100.0 / 49.4
    np.testing.assert_allclose(found.command[:1000], rest)
    again = plan([tie], [own], 20.0, seed=1, tried=6)
    np.testing.assert_array_equal(found.command, again.command)


def test_without_a_tie_it_is_the_parameters_that_count(rivals):
    _, own = rivals
    found = plan([], [own], 20.0, seed=1, tried=6)
    assert found.gain > found.staircase_gain > 1.0
    assert found.rivals == ()


def test_a_model_that_can_refit_is_nearer_than_one_that_cannot(rivals):
    tie, _ = rivals
    command = made(tie.one, TIME, [(k, 3) for k in KINDS.values()][:3])
    apart, slopes = _answers(tie, command)
    free, held = (replace(tie, information=size * np.eye(len(tie.names))) for size in (1e-9, 1e15))
    least = np.linalg.lstsq(slopes, apart, rcond=None)[0]
    assert distance(held, command) == pytest.approx(np.linalg.norm(apart), rel=1e-4)
    assert distance(free, command) == pytest.approx(np.linalg.norm(apart - slopes @ least), rel=1e-2)
    assert shrinks([held], command) == pytest.approx(1.0, abs=1e-4)


def test_a_straight_line_has_nothing_to_tell_of_its_curve():
    bent = Wrist.flexion() + Polynomial()
    tie = tied(bent, Wrist.flexion(), NAMES)
    assert distance(tie, staircase(bent, TIME)) == pytest.approx(0.0, abs=1e-6)
