"""What certificates are told as: each statement claims what its rung found, and no more."""

from itertools import product

import numpy as np
import pytest

from design.robustness.certificates.certificate import Certificate, LoopClass, Switching
from design.robustness.certificates.continuous.virgin import VirginBounds
from design.robustness.certificates.reasons import NoSolver, OtherLaw, UnstableBranch
from design.robustness.certificates.sampled.words import Word
from design.robustness.certificates.statements import (
    Arrive,
    Confirmed,
    Covered,
    NoneFound,
    NotFound,
    Unclipped,
    of_class,
    of_ladder,
    of_step,
    of_tasks,
    of_virgin_curve,
)
from design.status import Status

ABOUT = LoopClass(Switching.FIXED_LAW, (0.5, 9.0), (0.08, 0.36))
WORD = Word((0, 1), (0.1, 0.2), 1.1)
UNSOLVED = NoSolver("out of numbers")


def found(name, decay, dead_time=0.0, **evidence):
    return Certificate(name, ABOUT, dead_time, True, decay, 0.25, "CLARABEL", evidence=evidence)


def missed(name, reason=UNSOLVED, dead_time=0.0, word=None, **evidence):
    return Certificate(name, ABOUT, dead_time, False, None, None, "SCS", reason, word, evidence=evidence)


def region(step):
    return {"largest_step_deg": step}


def tasks(covered, clipped, runs=8):
    return {
        "covered": covered, "decay": 0.3, "runs": runs, "arrive": runs - (not covered), "latest_s": 1.5,
        "off_deg": 0.02, "clipped": clipped,
    }  # fmt: skip


def test_a_rung_that_found_a_function_is_proved_and_others_are_not():
    grows = UnstableBranch("line1", "fast", 0.2)
    rungs = [found("a", 0.7), missed("b"), missed("c", word=WORD), missed("d", grows)]
    told = of_ladder(rungs, ("load step",))
    statuses = [Status.PROVED, Status.OPEN, Status.DISPROVED, Status.DISPROVED]
    assert [s.status for s in told] == statuses
    assert [s.holds for s in told] == [True, None, False, False]
    assert [s.value for s in told] == [0.7, None, None, None]
    assert told[0].reason == Confirmed("CLARABEL", 0.25, ("load step",), "")
    assert told[2].reason == NotFound(UNSOLVED, WORD)
    assert all(s.claim.rung == c.rung and s.claim.about is ABOUT for s, c in zip(told, rungs, strict=True))


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0), (1, 2, 0)])
def test_a_class_is_told_of_by_the_rung_with_the_largest_decay(order):
    rungs = [found("slow", 0.1), found("quick", 0.9), missed("none", word=WORD)]
    told = of_class(Switching.FIXED_LAW, [rungs[k] for k in order])
    assert (told.status, told.value) == (Status.PROVED, 0.9)
    assert told.reason == Confirmed("CLARABEL", 0.25, (), "quick")


def test_a_class_without_a_function_is_open_unless_a_loop_of_it_grows():
    told = of_class(Switching.FIXED_LAW, [missed("a"), missed("b")])
    assert (told.status, told.holds, told.reason) == (Status.OPEN, None, NoneFound(("a", "b"), None))
    told = of_class(Switching.FIXED_LAW, [missed("a"), missed("b", word=WORD)])
    assert (told.status, told.holds) == (Status.DISPROVED, False)
    assert told.reason == NoneFound(("a", "b"), WORD)
    other = OtherLaw("anti-windup by tracking")
    told = of_class(Switching.FIXED_LAW, [missed("a", other), missed("b", other)])
    assert (told.status, told.reason) == (Status.OPEN, NotFound(other, None))


@pytest.mark.parametrize("step", [15.0, -15.0])
@pytest.mark.parametrize(("largest", "holds"), [(14.9, None), (15.0, True), (20.0, True)])
def test_a_step_is_covered_up_to_the_largest_of_the_widest_region(step, largest, holds):
    rungs = [found("a", 0.1, region=region(3.0)), found("b", 0.1, region=region(largest))]
    rungs += [missed("c", region=region(99.0)), found("d", 0.1, region=region(None)), found("e", 0.1)]
    (told,) = of_step(rungs, step)
    assert (told.holds, told.value, told.reason) == (holds, largest, Covered("b"))
    assert told.status is (Status.PROVED if holds else Status.OPEN)
    assert of_step(rungs[2:], step) == []


@pytest.mark.parametrize("step", [15.0, -15.0])
@pytest.mark.parametrize(
    ("covered", "clipped", "largest"), [*product([True, False], [0, 2], [None, 3.0, 20.0])]
)
def test_runs_that_are_never_clipped_tell_where_no_region_does(step, covered, clipped, largest):
    rungs = [found("runs", 0.1, tasks=tasks(covered, clipped))]
    rungs += [found("region", 0.1, region=region(largest))] if largest else []
    told = of_step(rungs, step)
    if largest == 20.0:
        assert [s.reason for s in told] == [Covered("region")]
    elif covered and not clipped:
        assert [(s.reason, s.value, s.holds) for s in told] == [(Unclipped("runs", 8), 15.0, True)]
    else:
        assert [(s.reason, s.holds) for s in told] == ([(Covered("region"), None)] if largest else [])


def test_each_dead_time_has_its_own_statement():
    rungs = [found("a", 0.1, t, region=region(r)) for t, r in ((0.0, 20.0), (0.05, 3.0))]
    rungs += [missed("b", dead_time=0.05, tasks=tasks(True, 0))]
    told = of_step(rungs, 15.0)
    assert [s.claim.dead_time for s in told] == [0.0, 0.05]
    assert [s.reason for s in told] == [Covered("a"), Unclipped("b", 8)]


@pytest.mark.parametrize("covered", [True, False])
def test_tasks_die_away_where_all_their_runs_arrive(covered):
    rungs = [found("a", 0.1, tasks=tasks(covered, 1), slowest_pole_1_s=0.9), found("b", 0.2)]
    (told,) = of_tasks(rungs, 15.0, ("load step",))
    assert told.value == (0.3 if covered else None)
    assert told.holds is (True if covered else None)
    assert told.reason == Arrive("a", 8, 8 if covered else 7, 1.5, 0.02, 1, 0.9, ("load step",))
    assert told.evidence["slowest_pole_1_s"] == 0.9


def test_the_virgin_curve_is_left_where_the_latest_time_is_a_time():
    left = of_virgin_curve(VirginBounds(16.0, 1.0, 2.5, 1.2, 16.4), 5.0)
    assert (left.status, left.holds, left.value) == (Status.PROVED, True, 2.5)
    stuck = of_virgin_curve(VirginBounds(16.0, 1.0, np.inf, 1.2, np.inf), 5.0)
    assert (stuck.status, stuck.holds, stuck.value) == (Status.DISPROVED, False, None)
