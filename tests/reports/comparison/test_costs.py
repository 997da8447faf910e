"""What being better costs is told in words and tables with units, and the summary stays true in bad cases."""

from dataclasses import replace

import pytest

from design.studies.study import Question
from reports.comparison.contest.table import main_table
from reports.comparison.costs import break_even_table, break_even_words, ledger_table, ledger_words
from reports.comparison.words import LATE, on_others, summary
from reports.shared.tables import number
from tests.reports.report_samples import (
    small_break_even,
    small_contest,
    small_decision,
    small_ledgers,
    small_study,
)


def test_too_few_plants_give_neither_interval_nor_rank():
    few = next(g for g in main_table(small_contest(), 5.0).groups if "(3 plants)" in g.heading)
    many = next(g for g in main_table(small_contest(), 5.0).groups if "(12 plants)" in g.heading)
    assert [(r[2].under, r[3].text) for r in few.rows] == [("", "–")] * 2
    assert all(r[3].text in ("1", "2", "1 to 2") for r in many.rows)
    assert many.rows[1][2].under


def test_how_wrong_a_model_may_be_is_told_with_signs_and_units():
    found = small_break_even()["flexion"]
    texts = [[cell.text for cell in r] for g in break_even_table(found).groups for r in g.rows]
    curve = found.of("loop width", "feedforward")
    low, high = curve.break_even("IAE")
    expected = [f"−{number(-100.0 * low, 2)} %", f"+{number(100.0 * high, 2)} %"]
    assert ["feedforward", "mean IAE", f"{float(curve.ratio('IAE')[1]):.2f}", *expected] in texts
    never = found.of("dead time", "feedforward").break_even("IAE")[1]
    assert (never is None) == any(t[-1] == "beyond 40 ms" for t in texts)
    words = break_even_words("flexion", found)
    assert f"a loop width off by {expected[0]} to {expected[1]}" in words
    assert ("any error of the dead time that was tried" in words) == (never is None)


def test_how_long_steps_take_stands_in_milliseconds_and_who_missed_is_named():
    ledgers = small_ledgers()
    assert ledger_words(ledgers).endswith(
        "; 5 of all 1100 steps took longer than their period, most of them the recommended PI's (5 of 1000)."
    )
    punctual = {"flexion": {"linear MPC": ledgers["flexion"]["linear MPC"]}}
    assert ledger_words(punctual) == (
        "The nearest to its period comes the linear MPC, of which 99 % of the steps are done within 0.5 % of "
        "the period; no step missed its period."
    )
    (group,) = ledger_table(ledgers).groups
    tuned, mpc = ([cell.text for cell in r] for r in group.rows)
    assert tuned == ["recommended PI", "1", "0.01", "0.01", "2", "1", "5 of 1000", "–", "–", "–", "–"]
    assert group.rows[0][6].broken
    assert mpc == ["linear MPC", "20", "0.1", "0.1", "0.1", "0.5", "0 of 100", "0.02", "0.05", "0.03", "1"]


@pytest.mark.slow
def test_the_opening_stays_true_where_limits_are_broken_and_nothing_settles():
    study = small_study()
    c = study.comparison
    slow = tuple(
        replace(s, breaks=("Ms", "overshoot_percent"), worst_settling_s=float("inf"))
        if s.controller == "tuned"
        else s
        for s in c.standings
    )
    broken = replace(c, standings=slow)
    said = summary(replace(study, comparison=broken, decisions={"flexion": small_decision()}))
    assert len(said) == 3
    assert all(len(s.split()) <= 20 for s in said)
    d = small_decision()
    beyond = d.evidence["samples"]["broken"] + d.evidence["worst_case"]["broken"]
    assert (f"break a limit in {beyond} of " in said[0]) == (beyond > 0)
    one = replace(c, standings=tuple(s for s in c.standings if s.motion == "flexion"))
    one = replace(one, standings=one.standings[:1])
    question = Question({"flexion": study.plants["flexion"]})
    alone = summary(replace(study, comparison=one, question=question))
    assert len(alone) == 3
    assert alone[0] == "No controller was judged by the whole requirement."
    assert "deviation" not in " ".join(alone)
    assert "no other controller within the limits settles faster" in alone[1]


@pytest.mark.slow
def test_a_leader_that_a_dead_time_undoes_is_named_as_such():
    study, contest = small_study(), small_contest()

    def lost(score):
        late = score.field.startswith(LATE)
        return replace(score, mean=dict(score.mean) | {"unsettled": 0.9 if late else score.mean["unsettled"]})

    calm = on_others(study.comparison, contest)
    undone = replace(contest, scores=tuple(lost(s) for s in contest.scores))
    said = on_others(study.comparison, undone)
    assert "to settle" not in calm
    late = " With a dead time of 50 ms that no model has, recommended PI fails to settle on most plants."
    assert said == calm + late
