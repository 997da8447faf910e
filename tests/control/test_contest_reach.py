"""Plants of the contest are those on which a command with some headroom holds the step, either way."""

import numpy as np
import pytest

from design.contest.plants import PlantField, first, within_reach
from design.evaluation.scenarios import HEADROOM
from plants import Wrist

WRIST = Wrist.flexion()


def field(**changed):
    count = len(next(iter(changed.values())))
    values = {n: np.full(count, v) for n, v in WRIST.values.items()} | changed
    return PlantField("made", Wrist.from_values(values), count, 3)


@pytest.mark.parametrize(
    "changed",
    [
        {"rest_pressure": np.linspace(40.0, 160.0, 61)},  # one end, the other
        {"a1": np.linspace(0.1, 0.6, 61)},
        {"a2": np.linspace(0.1, 0.6, 61)},
        {"w1": np.linspace(0.0, 20.0, 61), "w2": np.full(61, 4.0)},
        {"w2": np.linspace(0.0, 20.0, 61), "w1": np.full(61, 4.0)},
    ],
    ids=list,
)
def test_both_lines_are_held_within_the_range_less_the_headroom(changed):
    made = field(**changed)
    p, step = made.wrist.hysteresis, made.wrist.rig.task.step
    low, high = made.wrist.rig.command_range
    up = (p.rest_pressure + (step + p.w1) / p.a1) / made.wrist.regulator.gain
    down = (p.rest_pressure - (step + p.w2) / p.a2) / made.wrist.regulator.gain
    held = (down >= low + HEADROOM) & (up <= high - HEADROOM)
    assert 0 < held.sum() < made.count
    found = within_reach(made)
    assert (found.count, found.set_aside) == (held.sum(), 3 + (~held).sum())
    for name, values in changed.items():
        np.testing.assert_array_equal(found.wrist.values[name], values[held])


@pytest.mark.parametrize(("count", "left"), [(1, 1), (4, 4), (99, 6)])
def test_the_first_plants_are_the_first(count, left):
    made = field(a1=np.linspace(0.3, 0.4, 6))
    found = first(made, count, "few")
    assert (found.name, found.count) == ("few", left)
    np.testing.assert_array_equal(found.wrist.values["a1"], np.linspace(0.3, 0.4, 6)[:left])
