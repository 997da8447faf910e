"""Where kinds of statement seem to contradict each other the page says so, and only there."""

from types import SimpleNamespace

import pytest

from design.robustness.certificates.certificate import Certificate
from design.robustness.disagreement import disagreements
from design.robustness.samples.monte_carlo import counted
from design.robustness.statement import Statement
from design.robustness.verdict import verdict


def rung(holds, dead_time=0.0, name="quadratic and Popov", decay=0.1):
    return Certificate(name, "dies away", dead_time, holds, decay if holds else None, None, "CLARABEL", "no")


def case(requirement, broken, of=1000):
    return counted(requirement, f"{requirement} broken", None, "", [True] * broken + [False] * (of - broken))


def found(**changes):
    """An assessment in which the three kinds agree, but for what is changed."""
    agreeing = {
        "ladder": (rung(True), rung(True, 0.05)),
        "stable": True,
        "word": None,
        "margins": ({"delay_margin_s": 0.3, "stable": True},),
        "predictions": (Statement("prediction", "Ms at most 2", True, 1.7, "1"),),
        "certificates": (),
        "samples": (),
        "cases": SimpleNamespace(violations=(case("settles", 0), case("overshoot_percent", 0))),
        "conditions": SimpleNamespace(dead_time=0.05),
        "worst": SimpleNamespace(violated=()),
        "cycles": (),
        "left_out": (),
    }
    return SimpleNamespace(**{**agreeing, **changes})


def test_nothing_is_said_where_they_agree():
    assert disagreements(found()) == []


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"ladder": (rung(False), rung(False, 0.05))}, "no rung proves it"),
        ({"ladder": (rung(True), rung(False, 0.05))}, "no rung certifies the loop with 50 ms"),
        ({"cases": SimpleNamespace(violations=(case("overshoot_percent", 70),))}, "70 of 1000 samples"),
        ({"worst": SimpleNamespace(violated=("overshoot_percent",))}, "the search found a scenario"),
        ({"cycles": (SimpleNamespace(confirmed=False),)}, "1 of 1 limit cycles"),
    ],
)
def test_each_kind_of_contradiction_is_told(changes, words):
    (said,) = disagreements(found(**changes))
    assert words in said


def test_a_word_says_why_no_rung_can():
    (said,) = disagreements(found(ladder=(rung(False),), word="1 s of a, then 2 s of b"))
    assert "For slopes and rates that switch at will none can: 1 s of a, then 2 s of b." in said
    assert "All 1000 samples settled." in said


def test_unstable_loops_contradict_nothing():
    assert disagreements(found(stable=False, ladder=(rung(False),))) == []


def test_of_the_rungs_about_one_class_the_verdict_has_the_one_that_decays_fastest():
    ladder = (rung(True, decay=0.1), rung(False, name="sampled: a"), rung(True, name="sampled: b", decay=0.2))
    first, second = verdict(found(ladder=ladder, predictions=()))
    assert (first.value, second.value) == (0.1, 0.2)
    assert second.because.startswith("b, found by CLARABEL")


def test_of_branches_the_verdict_has_the_worst():
    rows = [
        Statement("certificate", "stable", holds, value, branch=branch)
        for holds, value, branch in ((True, 4.0, "transit"), (True, 3.0, "line1"), (None, 5.0, "line2"))
    ]
    (told,) = verdict(found(ladder=(), certificates=tuple(rows), predictions=()))
    assert told.branch == "line2"
    (told,) = verdict(found(ladder=(), certificates=tuple(rows[:2]), predictions=()))
    assert told.branch == "line1"
