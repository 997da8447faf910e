"""What a sequence is held against: steps of other sizes than the task's are scaled to it, and named."""

from dataclasses import replace

import numpy as np
import pytest

from design.controllers.pi import PI
from design.evaluation.cases import Case, as_lanes, repeated, stack
from design.evaluation.metrics import Metrics
from design.evaluation.runner import play
from design.evaluation.scaled import scaled
from design.evaluation.tasks import Task
from plants import Wrist

WRIST = Wrist.flexion()
TASK = WRIST.rig.task.step
FIGURES = Metrics(
    rise_time_s=0.4, settling_time_s=2.5, overshoot_percent=6.0, steady_state_error_deg=0.3, iae_deg_s=9.0,
    ise_deg2_s=50.0, itae_deg_s2=4.0, total_variation_V=3.0,
)  # fmt: skip


@pytest.mark.parametrize(
    ("size", "overshoot", "variation", "share"),
    [
        (15.0, 6.0, 3.0, 1.0),
        (30.0, 6.0, 1.5, 0.5),  # half of its travel, error per degree
        (7.5, 6.0, 3.0, 2.0),  # it must travel for the play of the loop all the same
        (2.5, 3.0, 3.0, 3.0),  # judged relative to a step of 5
        (0.0, 0.0, 3.0, 3.0),
    ],
)
def test_a_step_of_another_size_is_scaled_to_the_tasks(size, overshoot, variation, share):
    found = scaled(Metrics(**{n: np.array([v]) for n, v in vars(FIGURES).items()}), np.array([size]), 15.0)
    assert {n: float(v[0]) for n, v in found.items()} == pytest.approx({
        "overshoot_percent": overshoot, "steady_error_percent": 2.0, "total_variation_V": variation,
        "iae_deg_s": 9.0 * share, "itae_deg_s2": 4.0 * share, "settling_time_s": 2.5,
    })  # fmt: skip


def asked(references, holds, **more):
    dead_time, judged = more.pop("dead_time", 0.0), more.pop("judged", "task band")
    task = Task("virgin", more.pop("angle", 0.0), references, holds, judged, **more)
    return Case(task, WRIST, dead_time=dead_time)


def test_a_step_is_the_tasks_by_its_size_and_where_it_is_begun_calmly():
    assert asked((TASK,), (10.0,)).of_task
    assert asked((-TASK,), (10.0,)).of_task
    assert asked((0.0,), (10.0,), angle=TASK).of_task
    assert asked((TASK, 0.0), (3.0, 10.0)).of_task
    assert not asked((TASK, 0.0), (2.9, 10.0)).of_task
    assert not asked((TASK - 1.0,), (10.0,)).of_task
    assert not asked((TASK,), (10.0,), angle=1.0).of_task
    assert not asked((TASK,), (10.0,), load=1.0, load_at=0.0).of_task  # a mere load
    assert asked((TASK,), (10.0,), load=1.0).of_task


def test_a_sequence_is_said_in_words():
    found = asked((15.0, -10.0), (0.8, 10.0), dead_time=0.04)
    found = replace(found, task=replace(found.task, start="line2"))
    assert found.name == "+15 for 0.8 s, then -10 deg, from line2, nominal plant, 40 ms of dead time"
    assert asked((5.0,), (1.0,), load=-2.0).name == "+5 deg, from virgin, nominal plant, load -2 deg"
    late = asked((5.0,), (1.0,), load=2.0, load_at=0.5)
    assert late.name.endswith("load +2 deg after 0.5 s")
    with pytest.raises(ValueError, match="as many times"):
        asked((1.0, 2.0), (1.0,))
    with pytest.raises(ValueError, match="needs references"):
        asked((), ())


def test_a_shorter_sequence_among_longer_ones_is_played_as_alone():
    one, two = asked((15.0,), (1.0,)), asked((5.0, 15.0, -5.0), (0.2, 0.3, 1.2), load=0.5)
    gains = PI(3.0, 10.0)
    together = play(stack([one, two]), gains)
    for lane, alone in enumerate((one, two)):
        found = play(stack([alone]), gains)
        for name, values in found.values.items():
            assert together.values[name][lane] == pytest.approx(values[0], rel=1e-9), name
    both = stack([one, two])
    np.testing.assert_array_equal(both.reference.switches, [[0.0, 200.0], [0.0, 500.0]])
    np.testing.assert_array_equal(both.judge.window.lasts, [1000.0, 1200.0])
    twice = play(repeated(both, 2), gains)
    for name, values in together.values.items():
        np.testing.assert_array_equal(twice.values[name], np.tile(values, 2), err_msg=name)


def test_starts_of_lanes_are_their_own():
    """The state of each lane is the one that its start has alone."""
    references, holds = np.full((1, 3), 10.0), np.full((1, 3), 1.0)
    found = as_lanes(WRIST, ["virgin", "line1", "line2"], np.array([0.0, 5.0, -5.0]), references, holds)
    for lane, (start, angle) in enumerate((("virgin", 0.0), ("line1", 5.0), ("line2", -5.0))):
        alone = as_lanes(WRIST, [start], np.array([angle]), references[:, :1], holds[:, :1])
        assert np.asarray(found.state.pressure)[lane] == np.asarray(alone.state.pressure)[0]
        assert np.asarray(found.state.angle)[lane] == pytest.approx(angle, abs=1e-9)


@pytest.mark.parametrize("judged", ["own band", "task band"])
def test_the_band_is_that_of_the_step_or_of_the_tasks(judged):
    """A step of 5 degrees settles later in 2 % of it than in 2 % of the task's step, three times as large."""
    gains = PI(3.0, 10.0)
    played = play(stack([asked((5.0,), (4.0,), judged=judged)]), gains, record=True)
    error = np.abs(5.0 - np.asarray(played.trajectory.angle)[:4000, 0])
    band = WRIST.rig.task.band * (TASK if judged == "task band" else 5.0)
    settled = (np.flatnonzero(error >= band)[-1] + 1) * 1e-3
    assert float(played.metrics.settling_time_s[0]) == pytest.approx(settled, abs=1.5e-3)


@pytest.mark.parametrize("judged", ["own band", "task band"])
def test_a_joint_that_never_reached_the_reference_it_is_sent_back_to_makes_no_overshoot(judged):
    """Overshoot is motion beyond a reference in the direction of its change: held at -1 deg by a load, the
    joint is sent up and back to 0 before it has passed 0, and what carries it above 0 goes the other way."""
    gains = PI(0.5, 3.0)
    one = asked((15.0, 0.0), (0.5, 10.0), load=-1.0, judged=judged)
    played = play(stack([one]), gains, record=True)
    assert -1.0 < float(played.start[0]) < -0.05
    angle = np.asarray(played.trajectory.angle)[500:, 0]
    assert angle.max() > 0.3
    assert float(played.metrics.overshoot_percent[0]) == 0.0
    assert not np.isfinite(played.metrics.rise_time_s[0])
    beyond = play(stack([replace(one, task=replace(one.task, holds=(0.7, 10.0)))]), gains, record=True)
    lowest = np.asarray(beyond.trajectory.angle)[700:10_700, 0].min()
    share = -100.0 * lowest / float(beyond.start[0])
    assert float(beyond.metrics.overshoot_percent[0]) == pytest.approx(max(share, 0.0), abs=1e-9)
    assert share > 0.5


def test_a_joint_sent_back_before_it_got_there_settles_when_it_enters_the_band():
    """Sent to 15 and after 0.15 s back to 5 deg, below which it still is: it goes on upwards."""
    task = Task("virgin", 0.0, (15.0, 5.0), (0.15, 3.0))
    assert task.judged == "own band"
    went = play(stack([Case(task, Wrist.flexion())]), PI(3.1, 10.4), record=True)
    angle = went.trajectory.angle[:, 0]
    begin = angle[150]
    assert 0.0 < begin < 5.0
    outside = np.flatnonzero(np.abs(5.0 - angle[150:3150]) >= 0.02 * (5.0 - begin))
    settled = 0.001 * (outside[-1] + 1.0)
    wanted = settled if settled < 3.0 else np.inf
    assert went.metrics.settling_time_s[0] == pytest.approx(wanted, abs=0.0015)
    assert wanted > 2.0
    assert went.metrics.overshoot_percent[0] == 0.0
    assert np.isinf(went.metrics.rise_time_s[0])


def test_a_joint_that_is_where_it_is_sent_has_no_response():
    task = Task("virgin", 0.0, (15.0, 0.0), (0.5, 3.0))
    found = play(stack([Case(task, Wrist.flexion())]), PI(0.001, 0.001)).metrics
    assert found.overshoot_percent[0] == 0.0
    assert np.isinf(found.rise_time_s[0])
