"""A sequence of references is runs of the loop, one after the other, of which the last is judged."""

from dataclasses import fields

import numpy as np
import pytest

from design.controllers.pi import PI
from design.evaluation.cases import Case, as_lanes, repeated, stack
from design.evaluation.metrics import Metrics
from design.evaluation.runner import play
from design.evaluation.scenarios import STEP
from design.evaluation.steps import run
from design.evaluation.tasks import Task
from plants import Wrist
from plants.effects.regulator.dead_time import DeadTime, TubeDeadTime
from plants.effects.wrist.creep import Creep
from plants.effects.wrist.load_step import GradualLoad, LoadStep
from plants.errors import InputError
from plants.simulation.disturbance import BEFORE, burdened
from plants.wrist import STARTS

GAINS = (PI(1.2, 2.2), PI(12.0, 18.0))
NAMES = [f.name for f in fields(Metrics)]


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize(
    "wrist", [Wrist.flexion(), Wrist.deviation() + DeadTime(0.0503)], ids=["plain", "late"]
)
@pytest.mark.parametrize("band", ["own band", "task band"])
def test_one_step_is_a_run_of_the_loop_to_the_bit(wrist, start, band):
    for gains in GAINS:
        judged, _, went = run(wrist, gains, -STEP, wrist.rest(start), duration=4.0, record=True)
        played = play(stack([Case(Task(start, 0.0, (-STEP,), (4.0,), band), wrist)]), gains, record=True)
        assert {n: float(getattr(played.metrics, n)[0]) for n in NAMES} == {
            n: float(getattr(judged, n)[0]) for n in NAMES
        }
        for signal in ("angle", "static_angle", "pressure", "command", "measured"):
            assert np.array_equal(getattr(played.trajectory, signal), getattr(went, signal)), signal
        assert played.size[0] == STEP


def test_two_steps_are_two_runs_one_after_the_other():
    wrist, gains = Wrist.flexion(), PI(4.0, 9.0)
    _, middle, first = run(wrist, gains, 12.0, wrist.rest("line2"), duration=0.7, record=True)
    judged, _, second = run(wrist, gains, -3.0, middle.plant, middle.controller, duration=5.0, record=True)
    played = play(stack([Case(Task("line2", 0.0, (12.0, -3.0), (0.7, 5.0)), wrist)]), gains, record=True)
    assert np.array_equal(played.trajectory.angle, np.vstack([first.angle[:-1], second.angle]))
    assert played.start[0] == middle.plant.angle[0]
    alike = [n for n in NAMES if n != "total_variation_V"]
    assert [getattr(played.metrics, n)[0] for n in alike] == [getattr(judged, n)[0] for n in alike]
    # A run of the loop counts the total variation of the command from what its integrator holds; here it goes
    # on from the last command.
    before, after = first.command[-2, 0], second.command[0, 0]
    held = (gains.rest_pressure + middle.controller.integral[0]) / gains.gain
    expected = judged.total_variation_V[0] - abs(after - held) + abs(after - before)
    assert played.metrics.total_variation_V[0] == pytest.approx(expected, abs=1e-12)


def test_travel_of_the_last_step_is_that_of_its_commands():
    gains, holds = PI(4.0, 9.0), (0.7, 0.4, 3.0)
    asked = stack([Case(Task("inside", 0.0, (12.0, -3.0, 4.0), holds), Wrist.flexion())])
    played = play(asked, gains, record=True)
    commands, first = played.trajectory.command[:-1, 0], 1100
    travel = np.abs(np.diff(commands[first - 1 :])).sum()
    assert played.metrics.total_variation_V[0] == pytest.approx(travel, abs=1e-12)
    error = 4.0 - played.trajectory.angle[first:-1, 0]
    assert played.metrics.iae_deg_s[0] == pytest.approx(np.abs(error).sum() * 1e-3, rel=1e-12)
    assert np.array_equal(np.unique(played.reference[:, 0]), [-3.0, 4.0, 12.0])
    assert played.reference[699, 0] == 12.0
    assert played.reference[700, 0] == -3.0


def test_lanes_of_different_length_are_what_each_is_alone():
    wrist = Wrist.flexion()
    several = [
        Case(Task("virgin", 0.0, (15.0,), (3.0,)), wrist),
        Case(Task("line1", 4.0, (-10.0, 2.0, 9.0), (0.31, 2.2, 4.0)), wrist.with_values(Tw=0.2)),
        Case(Task("line2", -5.0, (5.0, -15.0), (1.0, 1.5)), wrist.with_values(w1=7.0)),
    ]
    together = play(stack(several), PI(6.0, 9.0), jobs=2)
    for i, s in enumerate(several):
        alone = play(stack([s]), PI(6.0, 9.0))
        assert [getattr(together.metrics, n)[i] for n in NAMES] == [
            getattr(alone.metrics, n)[0] for n in NAMES
        ]
    twice = play(repeated(stack(several), 2), PI(6.0, 9.0))
    assert np.array_equal(twice.metrics.iae_deg_s, np.tile(together.metrics.iae_deg_s, 2))


def test_dead_time_and_load_are_effects_beside_the_wrists_own():
    wrist = Wrist.flexion()
    assert burdened(wrist + TubeDeadTime(0.03, 0.02), 0.01, None).values["dead-time.delay"] == pytest.approx(
        0.04
    )
    creeping = burdened(wrist + Creep(0.1, 4.0), 0.01, 2.0)
    assert {e.NAME for e in creeping.effects} == {"creep", "dead-time", "load-step"}
    with pytest.raises(InputError, match="load step of its own"):
        burdened(wrist + LoadStep(1.0, 3.0), None, 1.0)
    with pytest.raises(InputError, match="load step of its own"):
        burdened(wrist + GradualLoad(), None, 1.0)
    carried = burdened(wrist + LoadStep(), None, 1.0, 3.0)  # at its null
    assert carried.values == burdened(wrist, None, 1.0, 3.0).values


@pytest.mark.parametrize("start", STARTS)
def test_a_loaded_wrist_rests_until_it_is_asked_to_move(start):
    """The controller holds the start: a reference where the wrist is moves nothing."""
    there = 2.0 if start == "virgin" else -4.0
    angle = 0.0 if start == "virgin" else there
    asked = Task(start, angle, (there, 10.0), (1.0, 1.0), load=2.0)
    still = Case(asked, Wrist.flexion(), dead_time=0.03)
    went = play(stack([still]), PI(4.0, 9.0), record=True).trajectory
    assert np.ptp(went.angle[:1000]) < 1e-9
    assert went.angle[0, 0] == pytest.approx(there)


def test_the_closed_form_of_rest_is_the_general_one():
    """Against `plants.equilibrium`, which looks for the pressure by bisection where there are effects."""
    wrist, load = Wrist.deviation(), np.array([-2.0, 0.5])
    for start in ("line1", "line2", "inside"):
        b = as_lanes(wrist, [start] * 2, 3.0, np.full((1, 2), 9.0), np.ones((1, 2)), np.full(2, 0.02), load)
        general = (wrist + DeadTime(0.02) + LoadStep(load, BEFORE)).rest(start, 3.0)
        assert b.state.pressure == pytest.approx(general.pressure, abs=1e-9)
        assert b.state.memory.h == pytest.approx(general.memory.h, abs=1e-9)


def test_a_tiny_last_step_does_not_make_a_large_overshoot():
    """Overshoot in percent of 5 deg where the step is smaller: from the recorded angle."""
    s = Case(Task("virgin", 0.0, (10.0, 5.0), (0.5, 6.0)), Wrist.flexion())
    played = play(stack([s]), PI(6.0, 12.0), record=True)
    angle = played.trajectory.angle[500:-1, 0]
    direction = np.sign(5.0 - angle[0])
    beyond = max(float(np.max((angle - 5.0) * direction)), 0.0)
    assert played.size[0] < 5.0
    assert beyond > 0.0
    assert played.values["overshoot_percent"][0] == pytest.approx(100.0 * beyond / 5.0, rel=1e-9)
