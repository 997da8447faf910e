"""A task says what is asked of any plant, stage by stage; which tasks may stand side by side is checked."""

import numpy as np
import pytest

from design.evaluation.cases import Case, on_lanes, stack
from design.evaluation.tasks import STAIRS, Task, comparison_tasks, side_by_side, tuning_tasks
from design.limit import limit
from plants import Wrist
from plants.rig import built_in_rig

WRIST, RIG = Wrist.flexion(), built_in_rig()


def test_stages_follow_each_other():
    task = Task("virgin", 0.0, (15.0, 5.0, -5.0), (2.0, 0.5, 4.0))
    assert task.stages == [(15.0, 0.0, 2.0), (5.0, 2.0, 0.5), (-5.0, 2.5, 4.0)]
    assert (task.duration, task.before, task.reference) == (6.5, 5.0, -5.0)


def test_the_last_step_by_itself_begins_at_rest_where_the_one_before_arrives():
    there = Task("virgin", 0.0, (15.0, 0.0), (5.0, 10.0))
    assert there.last == Task("line1", 15.0, (0.0,), (10.0,))
    assert Task("inside", 0.0, (-15.0, 0.0), (5.0, 10.0)).last.start == "line2"
    alone = there.last
    assert alone.last is alone
    assert limit(Case(there, WRIST)) == limit(Case(there.last, WRIST))


def test_tasks_in_lists_have_ids_of_their_own():
    for tasks in (comparison_tasks(RIG), side_by_side(RIG)):
        assert len({t.id for t in tasks}) == len(tasks)
    assert {t.duration for t in side_by_side(RIG)} == {8.0}
    assert {t.duration for t in tuning_tasks(RIG, 3.0)} == {3.0}


def test_tasks_that_are_judged_in_different_ways_or_stairs_of_different_lengths_are_refused():
    one, other = (Case(Task("virgin", 0.0, (15.0,), judged=j), WRIST) for j in ("own band", "task band"))
    with pytest.raises(ValueError, match="judged in different ways"):
        stack([one, other])
    stairs = [Task("virgin", 0.0, (15.0,), (held,), "stairs") for held in (1.0, 2.0)]
    with pytest.raises(ValueError, match="as long"):
        on_lanes(WRIST, stairs)


def test_shorter_tasks_first_hold_their_start_for_no_time():
    """The first stair of each is then a change from where it starts, and judged from its beginning."""
    asked = [t for t in side_by_side(RIG) if t.id in ("step-line1", "staircase+", "load+at+")]
    lanes = on_lanes(WRIST, asked, longest=len(STAIRS))
    assert [t.id for t in asked] == ["step-line1", "staircase+", "load+at+"]
    np.testing.assert_array_equal(np.transpose(lanes.reference.references)[0], [0.0, 0.0, 0.0, -15.0])
    np.testing.assert_array_equal(np.transpose(lanes.reference.references)[2], [15.0] * 4)
    np.testing.assert_array_equal(lanes.judge.window.begins, [0.0, 0.0, 1000.0])
    first = lanes.reference.at(0.0)
    np.testing.assert_array_equal(first.reference, [-15.0, 8.0, 15.0])
    np.testing.assert_array_equal(first.before, [0.0, 0.0, 15.0])


def test_no_window_is_judged_where_every_lane_is_one_step_of_the_same_length():
    first = Case(Task("virgin", 0.0, (15.0,), (2.0,)), WRIST)
    alike, mixed = ([first, Case(Task("line1", 0.0, (-15.0,), (t,)), WRIST)] for t in (2.0, 3.0))
    assert stack(alike).judge.window == ()
    assert stack(alike).lasts is None
    np.testing.assert_array_equal(stack(mixed).lasts, [2000, 3000])
