"""Gains that were given stay as they are, and are shown on the hardest cases that a pool has for them."""

from dataclasses import replace

import numpy as np
import pytest

from design.controllers.pi_two_dof import TwoDofPI
from design.evaluation.cases import stack
from design.evaluation.runner import play
from design.robustness.requirement import requirement
from design.robustness.tuning.given_gains import DEAR, NEAR, given_gains
from design.synthesis.answer import answer, refusal
from design.synthesis.tuning import Region
from plants import Wrist
from plants.parameters.files import built_in
from reports.comparison.words import evidence, found
from reports.shared.tuning import refused

COARSE = Region(points=4)


def asked():
    return replace(requirement(built_in("flexion")), kinds=("step", "return"))


@pytest.fixture(scope="module")
def timid():
    return given_gains(asked(), TwoDofPI.of(Wrist.flexion(), 3.0, 7.0, 0.7, 0.0), COARSE)


def test_the_gains_stay_and_hold_cases_that_are_played_one_by_one(timid):
    assert timid.gains == {"Kp": 3.0, "Ki": 7.0, "b": 0.7, "Tf": 0.0}
    cases = timid.problem.adverse
    assert NEAR <= len(cases) <= NEAR + DEAR
    controller = TwoDofPI.of(Wrist.flexion(), 3.0, 7.0, 0.7, 0.0)
    over = [play(stack([c]), controller).values["overshoot_percent"][0] for c in cases]
    assert timid.at.values["overshoot_percent"][0] >= max(over)
    assert timid.feasible is (float(timid.at.worst_excess[0]) <= 0.0)
    assert refusal(timid) is None
    assert timid.map.Kp.size == COARSE.points**2
    assert timid.searches == ()


def test_the_cases_are_harder_than_those_of_chance(timid):
    space = asked().space
    x = np.random.default_rng(5).random((space.size, 200))
    chance = asked().run(x[:, space.reachable(x)], timid.controller)["overshoot_percent"]
    shown = [play(stack([c]), timid.controller).values["overshoot_percent"][0] for c in timid.problem.adverse]
    assert max(shown) >= np.quantile(chance, 0.99)


@pytest.mark.slow
def test_gains_that_break_a_limit_are_refused_as_they_are():
    bold = given_gains(asked(), TwoDofPI.of(Wrist.flexion(), 20.0, 100.0, 1.0, 0.0), COARSE)
    assert (bold.Kp, bold.Ki) == (20.0, 100.0)
    assert refused(refusal(bold)).startswith("no: the given gains, Kp 20, Ki 100, break a limit: ")


def test_the_words_say_that_nothing_was_searched(timid):
    told = answer(timid)
    assert "The gains come from the design" in found(told)
    assert "Nearest limit: " in found(told)
    assert evidence(told).startswith("No search was made here: the map of 4 × 4 gains")
