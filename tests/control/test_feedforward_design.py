"""The tuned PI + feedforward holds the limits of the PI, and is judged by the same loop and margins."""

import numpy as np
import pytest

from design.alternatives.feedforward_design import design_feedforward, judge
from design.controllers.feedforward import FeedforwardPI
from design.evaluation.steps import run
from design.open_loops import by_python_control
from design.synthesis.evaluate import evaluate
from design.synthesis.requirements import Limits, default_problem
from plants.effects.wrist.creep import Creep
from plants.errors import InputError
from plants.wrist import Wrist

WRIST = Wrist.deviation()


@pytest.fixture(scope="module")
def problem():
    return default_problem(WRIST, nominal=True, jobs=1)


@pytest.fixture(scope="module")
def design(problem):
    return design_feedforward(problem)


def test_it_holds_every_limit_at_less_cost_than_the_tuned_pi(problem, design):
    assert design.breaks == ()
    assert design.at.feasible[0]
    assert design.at.cost[0] < evaluate(problem, 6.76, 19.7).cost[0]


def test_its_margins_are_those_of_python_control(design):
    rows = by_python_control(WRIST, design.controller.pi)
    assert design.at.values["Ms"][0] == pytest.approx(max(r["Ms"] for r in rows), rel=1e-3)
    least = min(r["delay_margin_s"] for r in rows)
    assert design.at.values["delay_margin_s"][0] == pytest.approx(least, rel=1e-3)
    assert least >= Limits().delay_margin_s * 0.999


def test_the_judgement_is_that_of_single_runs(problem):
    place = np.array([[12.0, 4.0, 12.0]])
    at = judge(problem, place)
    controller = FeedforwardPI.of(WRIST, speed=12.0, Kp=4.0, Ki=12.0)
    iae = [
        float(
            run(WRIST, controller, s.task.reference, s.wrist.rest(s.task.start, s.task.angle))[0].iae_deg_s[0]
        )
        for s in problem.scenarios
    ]
    assert at.cost[0] == pytest.approx(max(iae), abs=1e-12)
    assert (
        problem.scenarios[at.cost_at[0]].task.reference
        == problem.scenarios[int(np.argmax(iae))].task.reference
    )


def test_a_wrist_without_an_inverse_is_refused():
    with pytest.raises(InputError, match="no inverse of the effect creep"):
        design_feedforward(default_problem(WRIST + Creep(0.1, 4.0), nominal=True, jobs=1))
