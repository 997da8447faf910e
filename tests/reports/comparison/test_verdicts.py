"""A verdict ranks only what the whole range of the paper's gains agrees on, and is of the recommended PI."""

from dataclasses import replace

import numpy as np
import pytest

from design.comparison.compare import PAPER, TUNED, Comparison, Row, Standing
from design.studies.verdict import verdicts
from design.synthesis.answer import LimitBroken
from design.synthesis.requirements import Limits
from reports.comparison.verdict_words import verdict_sentence, verdict_sentences
from tests.reports.report_samples import small_study


def made_up(ours: float, low: float, high: float) -> str:
    """The verdict on a tuned PI that settles in `ours` against a paper's between `low` and `high`."""
    rows = [
        Row("flexion", "task", TUNED, *[{"settling_time_s": ours}] * 3, "id"),
        Row("flexion", "task", PAPER, {"settling_time_s": (low + high) / 2}, {"settling_time_s": low},
            {"settling_time_s": high}, "id"),
    ]  # fmt: skip
    standings = [Standing("flexion", name, 1.0, 1.0, 1.5, 0.1, 0.0, 1.0, 1.0, ()) for name in (TUNED, PAPER)]
    comparison = Comparison(tuple(rows), tuple(standings), {}, Limits())
    ((motion, verdict),) = verdicts(comparison, {}).items()
    return verdict_sentence(motion, verdict, 15.0)


@pytest.mark.parametrize("ours", [2.0, 3.0, 4.0])
def test_within_the_range_of_the_paper_nothing_is_ranked(ours):
    said = made_up(ours, 2.0, 4.0)
    assert "not ranked" in said
    assert "faster" not in said
    assert "slower" not in said


def test_outside_of_the_range_the_order_is_said():
    assert "faster than the paper's PI over the whole range" in made_up(1.99, 2.0, 4.0)
    assert "slower than the paper's PI over the whole range" in made_up(4.01, 2.0, 4.0)


def test_what_never_settles_is_never_said_to_be_ahead():
    assert "not ranked" in made_up(np.inf, np.inf, np.inf)
    assert "slower" in made_up(np.inf, 2.0, 4.0)
    assert "more than 10 s" in made_up(np.inf, 2.0, 4.0)


@pytest.mark.slow
def test_there_is_one_for_each_motion():
    assert list(small_study().verdicts) == ["flexion", "deviation"]


@pytest.mark.slow
def test_the_tuned_PI_is_the_one_that_is_compared_with_the_paper():
    comparison = small_study().comparison
    kept = (TUNED, PAPER)
    alone = replace(
        comparison,
        rows=tuple(r for r in comparison.rows if r.controller in kept),
        standings=tuple(s for s in comparison.standings if s.controller in kept),
    )
    for motion, verdict in verdicts(comparison, {}).items():
        assert replace(verdict, breaking=()) == verdicts(alone, {})[motion]
        assert verdict.tuned == next(
            s.worst_settling_s for s in comparison.standings if (s.motion, s.controller) == (motion, TUNED)
        )


@pytest.mark.slow
def test_gains_that_break_a_limit_are_called_the_nearest():
    no = LimitBroken((0.1, 20.0), (0.1, 50.0), 1.0, 2.0, "Ms", 3.0, 2.0, "line1, fast rate")
    study = small_study()
    answers = {m: replace(a, refusal=no) for m, a in study.answers.items()}
    said, other = verdict_sentences(replace(study, answers=answers))
    assert said.startswith(
        "flexion: no: no gains in Kp 0.1 to 20, Ki 0.1 to 50 meet every limit; nearest are "
    )
    assert said.endswith(
        "Ms is 3 against 2 on line1, fast rate; the tuned gains shown are the nearest found."
    )
    assert other.startswith("deviation: the recommended PI settles")
