"""The paper's own residual, reconstructed: a curved loop departs from the straight one seconds after a step.

At about 6 s for a curvature that the trace then names.
"""

import pytest

from benchmarks.section_7_2 import PAPER, STEPS, departure, reconstruct
from tests.rig.wrist_effects import Curvature


@pytest.mark.parametrize("step", STEPS)
def test_the_more_curved_the_larger_and_the_later_is_the_departure(step):
    flat, curved = (departure(Curvature(2, knee=k), step) for k in (150.0, 105.0))
    assert curved[0] > flat[0]
    assert curved[1] > flat[1]


def test_a_straight_loop_does_not_depart():
    assert departure(Curvature(), 15.0)[0] == 0.0


@pytest.mark.suite
def test_the_curvature_that_departs_at_about_6_s_is_named_and_explained():
    found = reconstruct()
    assert all(abs(t - PAPER) < 0.6 for _, t in found.nearest.values())
    assert [e.name for e in found.trace.effects] == ["branch-curvature"]
    assert found.trace.verdict == "explained"
    assert found.trace.after["angle_deg"] < 0.2 * found.trace.before["angle_deg"]
