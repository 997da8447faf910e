"""What a trace must reach, on 52 campaigns of a rig that shares no code with the library.

Takes minutes, so it runs apart: ``make suite`` traces every third campaign, ``make campaigns`` all of them.
"""

import os

import numpy as np
import pytest

from tests.rig.suite import write_suite
from tests.trace.traces import KNOWN, NOTHING, OUTSIDE, Judged, judge_suite

pytestmark = pytest.mark.suite
SEED = 7
EVERY = 1 if os.environ.get("WRIST_CAMPAIGNS") == "all" else 3
"""The campaigns are in a random order."""

DEAD_BANDS = "regulator-deadband"


@pytest.fixture(scope="module")
def judged(tmp_path_factory) -> list[Judged]:
    root = tmp_path_factory.mktemp("suite")
    write_suite(root, SEED)
    found = judge_suite(root, EVERY)
    for j in found:
        print("right" if j.right else "WRONG", j, f"{j.ratio:.2f}")
    return found


def kind(judged: list[Judged], wanted: str) -> list[Judged]:
    found = [j for j in judged if j.wanted == wanted]
    assert found
    return found


def test_the_exact_set_of_effects_is_named_in_nine_of_ten(judged):
    known = kind(judged, KNOWN)
    assert sum(j.right for j in known) >= 0.9 * len(known), [str(j) for j in known if not j.right]


def test_where_nothing_is_missing_nothing_is_found(judged):
    assert [str(j) for j in kind(judged, NOTHING) if not j.right] == []


def test_effects_outside_the_vocabulary_are_left_unexplained(judged):
    outside = kind(judged, OUTSIDE)
    assert sum(j.right for j in outside) >= 0.8 * len(outside), [str(j) for j in outside if not j.right]


def test_the_error_after_comes_near_the_noise(judged):
    explained = [j.ratio for j in kind(judged, KNOWN) if DEAD_BANDS not in j.truth["effects"]]
    assert np.median(explained) <= 1.3


def test_the_error_after_is_never_above_the_error_before(judged):
    worse = [str(j) for j in judged if j.trace.after["angle_deg"] > 1.0001 * j.trace.before["angle_deg"]]
    assert worse == []


def test_the_noise_floor_is_the_true_noise_within_a_tenth(judged):
    for j in judged:
        assert j.trace.noise["angle_deg"] == pytest.approx(j.truth["angle_noise_deg"], rel=0.1), str(j)
        assert j.trace.noise["pressure_kPa"] == pytest.approx(j.truth["pressure_noise_kPa"], rel=0.1), str(j)
