"""Where kinds of statement seem to contradict each other the page says so, and only there."""

from types import SimpleNamespace

import pytest

from design.robustness.certificates.certificate import Certificate, LoopClass, Switching
from design.robustness.certificates.reasons import NoSolver
from design.robustness.certificates.sampled.words import Word
from design.robustness.predictions.margins import MarginHeld, OfRows, StableEverywhere
from design.robustness.samples.monte_carlo import counted
from design.robustness.statement import Statement
from design.robustness.verdict import verdict
from design.status import Status, of_proof
from reports.robustness.disagreements import disagreement_sentences as disagreements
from reports.robustness.reasons import because

LAW, SAMPLE = (LoopClass(s, (0.5, 9.0), (0.08, 0.36)) for s in (Switching.FIXED_LAW, Switching.EVERY_SAMPLE))


def rung(holds, dead_time=0.0, name="quadratic and Popov", decay=0.1, about=LAW, word=None):
    reason = None if holds else NoSolver("no")
    decay = decay if holds else None
    return Certificate(name, about, dead_time, holds, decay, None, "CLARABEL", reason, word)


def case(requirement, broken, of=1000):
    return counted(requirement, f"{requirement} broken", None, "", [True] * broken + [False] * (of - broken))


def found(**changes):
    """An assessment in which the three kinds agree, but for what is changed."""
    agreeing = {
        "ladder": (rung(True), rung(True, 0.05)),
        "stable": True,
        "word": None,
        "margins": ({"delay_margin_s": 0.3, "stable": True},),
        "predictions": (Statement(Status.PREDICTED, MarginHeld("Ms", True, 2.0), True, 1.7, OfRows(), "1"),),
        "certificates": (),
        "samples": (),
        "cases": SimpleNamespace(violations=(case("settles", 0), case("overshoot_percent", 0))),
        "conditions": SimpleNamespace(dead_time=0.05),
        "worst": SimpleNamespace(violated=()),
        "cycles": (),
        "left_out": (),
        "other_law": "",
    }
    return SimpleNamespace(**{**agreeing, **changes})


def test_nothing_is_said_where_they_agree():
    assert disagreements(found()) == []


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"ladder": (rung(False), rung(False, 0.05))}, "no certificate proves it"),
        ({"ladder": (rung(True), rung(False, 0.05))}, "no certificate covers the loop with 50 ms"),
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
    assert "For arbitrarily switching slopes and rates none exists: 1 s of a, then 2 s of b." in said
    assert "All 1000 samples settled." in said


def test_unstable_loops_contradict_nothing():
    assert disagreements(found(stable=False, ladder=(rung(False),))) == []


def test_of_the_rungs_about_one_class_the_verdict_has_the_one_that_decays_fastest():
    ladder = (rung(True, decay=0.1), rung(False, name="a", about=SAMPLE))
    ladder = (*ladder, rung(True, name="b", decay=0.2, about=SAMPLE))
    first, second = verdict(found(ladder=ladder, predictions=()))
    assert (first.value, second.value) == (0.1, 0.2)
    assert because(second).startswith("b, found by CLARABEL")


def test_of_branches_the_verdict_has_the_worst():
    rows = [
        Statement(of_proof(holds), StableEverywhere(), holds, value, OfRows(), branch=branch)
        for holds, value, branch in ((True, 4.0, "transit"), (True, 3.0, "line1"), (None, 5.0, "line2"))
    ]
    (told,) = verdict(found(ladder=(), certificates=tuple(rows), predictions=()))
    assert told.branch == "line2"
    (told,) = verdict(found(ladder=(), certificates=tuple(rows[:2]), predictions=()))
    assert told.branch == "line1"


def test_a_class_with_a_known_word_is_disproved_and_one_without_is_open():
    word = Word((0, 1), (1.0, 2.0), 1.3)
    ladder = (rung(False), rung(False, name="a", about=SAMPLE, word=word))
    law, sample = verdict(found(ladder=ladder, predictions=()))
    assert (law.status, law.holds) == (Status.OPEN, None)
    assert (sample.status, sample.holds) == (Status.DISPROVED, False)
    assert because(sample) == "none found (a); none exists: a destabilising switching sequence is known"
