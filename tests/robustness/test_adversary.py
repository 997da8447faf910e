"""The search finds the worst case where it is known, and never a milder one than chance does."""

from dataclasses import replace

import numpy as np
import pytest

from design.controllers.lqi import LQI
from design.controllers.pi import PI
from design.evaluation.cases import stack
from design.evaluation.runner import play
from design.mpc.formulations.linear import linear_mpc
from design.mpc.problem import MPCProblem
from design.robustness.box import Box, box_of
from design.robustness.intervals import Interval
from design.robustness.samples.adversary import worst_case
from design.robustness.samples.search_space import Space, reference
from design.robustness.samples.worst import excesses, scores
from design.synthesis.requirements import Limits
from plants import Wrist
from plants.effects.wrist.end_stop import HardStop
from plants.errors import InputError
from plants.parameters.files import built_in

LIMITS = Limits()
SHORT = 4.0


def small_box() -> Box:
    return box_of(built_in("flexion"))


@pytest.mark.slow
def test_a_known_corner_is_found():
    """One slow step: the IAE of a loop that neither clips nor overshoots is ruled by the pressure that its
    integrator must gather, IAE = (pressure needed) / Ki, so the widest, flattest loop from the far line is
    the worst, and the smallest step costs the most per degree."""
    plant = built_in("flexion")
    box = Box(plant, tuple(i for i in small_box().intervals if i.name in ("slopes", "widths")))
    gains = PI(3.0, 1.0)
    found = worst_case(box, gains, "cost", steps=1, budget=1500, duration=60.0)
    c, s = found.case, found.case.task
    v, w = c.wrist.values, plant.values
    assert v["a1"] == pytest.approx(0.9 * w["a1"], rel=1e-3)
    assert v["w1"] == pytest.approx(1.2 * w["w1"], rel=1e-3)
    assert abs(s.references[0]) == pytest.approx(5.0, abs=0.01)
    assert s.start == ("line2" if s.references[0] > 0 else "line1")
    step = abs(s.references[0])
    pressure = (step + v["w1"]) / v["a1"] + v["w2"] / v["a2"]  # from the one line to the other and along it
    assert found.cost_per_deg == pytest.approx(pressure / gains.Ki / step, rel=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "objective"), [(0, "excess"), (1, "excess"), (2, "excess"), (0, "cost")])
def test_never_milder_than_as_many_random_draws(seed, objective):
    gains, space = PI(2.882, 8.798), Space(small_box(), 3, 0.03, 1.0, SHORT)
    x = np.random.default_rng(1000 + seed).random((space.size, 2000))
    drawn = np.where(
        space.reachable(x),
        scores(play(space.lanes(x), gains).values, LIMITS, objective, 15.0),
        -np.inf,
    )
    found = worst_case(
        space.box, gains, objective, dead_time=0.03, load=1.0, seed=seed, budget=2000, duration=SHORT
    )
    assert found.evaluations <= 2000
    assert (found.excess if objective == "excess" else found.cost_per_deg) >= drawn.max()


WRIST = Wrist.flexion()
KINDS = {
    "PI": (PI(2.882, 8.798), {"budget": 500, "duration": SHORT}),
    "LQI": (
        LQI(Ke=50.0, Kd=-50.0, Kq=-14.0, jump=3.5, slope=0.2, Tw=0.16, bandwidth=20.0),
        {"budget": 100, "duration": SHORT},
    ),
    "MPC": (linear_mpc(MPCProblem(WRIST)), {"budget": 64, "duration": 1.0, "steps": 1}),
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_what_is_told_is_what_the_scenario_does_whatever_the_controller(kind):
    controller, effort = KINDS[kind]
    found = worst_case(small_box(), controller, dead_time=0.03, load=1.0, **effort)
    played = play(stack([found.case]), found.controller)
    assert found.metrics == {n: float(v[0]) for n, v in vars(played.metrics).items()}
    broken = {n for n, v in excesses(played.values, LIMITS).items() if v[0] > 0.0}
    assert set(found.violated) == broken
    assert found.excess == max(float(v[0]) for v in excesses(played.values, LIMITS).values())
    assert 0.0 <= found.case.dead_time <= 0.03
    assert abs(found.case.task.load) <= 1.0


@pytest.mark.slow
def test_the_same_for_a_seed_and_any_number_of_threads():
    found = [
        worst_case(small_box(), PI(2.882, 8.798), seed=4, budget=400, duration=SHORT, jobs=jobs)
        for jobs in (1, 3)
    ]
    assert found[0] == found[1]
    other = worst_case(small_box(), PI(2.882, 8.798), seed=5, budget=400, duration=SHORT)
    assert other.case != found[0].case


def test_cost_is_maximised_where_no_limit_is_broken():
    easy = Limits(overshoot_percent=300.0, steady_error_percent=300.0, total_variation_V=500.0)
    found = worst_case(small_box(), PI(2.882, 8.798), limits=easy, budget=400, duration=SHORT)
    assert (found.objective, found.violated) == ("cost", ())
    assert found.greatest_excess < 0.0
    assert 400 < found.evaluations <= 800
    assert found.cost_per_deg > found.plain.cost_per_deg  # smaller steps cost more per degree


def test_places_are_within_the_task():
    space = Space(small_box(), 4, 0.05, 2.0, SHORT)
    asked = space.asked(np.random.default_rng(0).random((space.size, 3000)))
    angles = np.vstack([np.zeros(3000), asked["references"]])
    assert np.abs(angles).max() <= 15.0
    assert np.abs(np.diff(angles, axis=0)).min() >= 5.0 - 1e-12
    assert asked["holds"][:-2].min() >= space.hold[0]
    assert asked["holds"][:-2].max() <= space.hold[1]
    assert asked["holds"][-2].min() >= space.calm[0]
    assert set(asked["starts"]) == {"virgin", "line1", "line2", "inside"}
    ends = reference(np.array([0.0, 1.0, 1.0]), np.array([-15.0, -15.0, 15.0]), 15.0)
    assert ends.tolist() == [-10.0, 15.0, 10.0]


@pytest.mark.suite
def test_what_is_out_of_reach_is_never_the_worst():
    """A stop at 8 deg: no reference beyond it, where the error would stay for ever."""
    plant = built_in("flexion").revised(
        [HardStop], {"end-stop.low": -90.0, "end-stop.high": 8.0}, {}, "a test"
    )
    box = replace(small_box(), plant=plant)
    found = worst_case(box, PI(2.882, 8.798), budget=100, duration=SHORT)
    assert found.set_aside > 0
    assert max(found.case.task.references) <= 8.0


def test_a_box_of_which_nothing_is_within_reach_is_refused():
    plant = built_in("flexion")
    values = {**plant.parameters, "gain": replace(plant.parameters["gain"], value=20.0, low=1.0)}
    weak = replace(plant, parameters=values)
    box = Box(weak, (Interval("Tw", 0.1, 0.16, 0.2, "s", "given"),))
    with pytest.raises(InputError, match="no sequence was found"):
        worst_case(box, PI(2.0, 2.0), budget=100, duration=1.0)


@pytest.mark.parametrize(
    ("what", "words"),
    [
        ({"dead_time": -0.1}, "dead time"),
        ({"dead_time": float("nan")}, "dead time"),
        ({"load": -1.0}, "load"),
        ({"steps": 0}, "steps"),
        ({"budget": 3}, "budget"),
        ({"duration": 0.0}, "duration"),
    ],
)
def test_bad_input_is_told_in_one_line(what, words):
    with pytest.raises(InputError, match=words) as error:
        worst_case(small_box(), PI(2.0, 2.0), **what)
    assert "\n" not in str(error.value)
