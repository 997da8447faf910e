"""The page of robustness opens with what was seen, foreseen and proved, also where that is little."""

from dataclasses import replace

import pytest

from design.robustness.certificates.statements import TasksDieAway
from reports.robustness.page import SECTIONS
from reports.robustness.tables import verdict_table
from reports.robustness.words import card_row, details, summary
from reports.shared.card import matrix_table
from reports.shared.tables import number
from tests.reports.html_page import Page, summary_of
from tests.reports.report_samples import small_assessment, small_robustness

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def assessed():
    return small_assessment()


@pytest.fixture(scope="module")
def text(written_robust):
    return written_robust.text


def test_it_opens_with_three_sentences_that_hold_the_numbers(text, assessed):
    opening = summary_of(text)
    assert opening == summary(assessed)
    assert len(opening) == 3
    assert all(len(s.split()) <= 20 for s in opening)
    broken = assessed.required.broken
    verdict = "No" if broken or assessed.worst.violated else "Yes"
    assert opening[0].startswith(f"{verdict}: {broken} of {assessed.required.total} samples break a limit")
    Ms = max(m["Ms"] for m in assessed.margins)
    assert f"Ms is {number(Ms)} (limit: 2)" in opening[1]
    assert "ms (limit: 60 ms)" in opening[1]
    tasks = [s for s in assessed.certificates if isinstance(s.claim, TasksDieAway)]
    assert all(s.holds for s in tasks)
    assert f"rate at least {number(min(s.value for s in tasks), 2)} 1/s" in opening[2]
    assert "50 ms of dead time" in opening[2]


def test_the_first_section_says_the_same_in_full(text, assessed):
    full = details(assessed)
    assert full[0].startswith("None of 60 independent simulated single steps breaks a requirement, ")
    assert f"a search of {assessed.worst.evaluations} runs" in full[0]
    switched = [c for c in assessed.ladder if c.holds and c.dead_time and not c.remembers]
    assert f"rate at least {number(max(c.decay for c in switched), 2)} 1/s" in full[2]
    shown = Page(text).text
    assert all(s in shown for s in full)


def test_the_card_marks_what_is_met_and_what_is_broken(assessed):
    study = small_robustness()
    named = assessed.limits.named
    for found in (
        study,
        replace(study, assessment=replace(assessed, limits=replace(assessed.limits, Ms=1.01))),
    ):
        rows = {r["limit"]: r for r in card_row(found).matrix}
        assert list(rows) == list(named)
        worst = max(m["Ms"] for m in assessed.margins)
        assert rows["Ms"]["held"]["every branch and memory"] is (worst <= rows["Ms"]["bound"])
        assert rows["Ms"]["held"]["worst case found"] is None  # a margin is no matter of one case
        over = rows["overshoot_percent"]
        assert over["values"]["perturbed plants"] == assessed.required.values["overshoot_percent"].max()
        cells = matrix_table([card_row(found)]).groups[0].rows
        assert sum(c.broken for r in cells for c in r) == sum(
            v is False for r in rows.values() for v in r["held"].values()
        )


def test_every_section_is_there_in_the_order_of_the_contents(text):
    page = Page(text)
    ids = [a["id"] for t, a in page.tags if t == "h2"]
    assert ids == [*SECTIONS, "made"]
    links = [a["href"] for t, a in page.tags if t == "a"]
    assert links == [f"#{name}" for name in SECTIONS]


def test_samples_stand_first_and_what_has_no_limit_is_said_to_have_none(assessed):
    groups = verdict_table(assessed).groups
    assert [g.heading.split(":")[0] for g in groups] == ["Samples", "Predictions", "Certificates"]
    holds = {r[0].text: r[1].text for g in groups for r in g.rows}
    assert holds["phase margin on every branch"] == "no limit"
    assert holds["Ms at most 2 on every branch"] == "met"
    assert not any("line1" in cell.text for g in groups for r in g.rows for cell in r[3:4])


def test_nothing_proved_and_something_unstable_and_broken_is_said_so(assessed):
    rungs = tuple(replace(c, holds=False, decay=None) for c in assessed.ladder)
    margins = ({**assessed.margins[0], "stable": False}, *assessed.margins[1:])
    broken = replace(assessed.cases.violations[0], count=9, trials=60, low=0.071, high=0.266)
    cases = replace(assessed.cases, violations=(broken, *assessed.cases.violations[1:]))
    worst = replace(assessed.worst, violated=())
    poor = replace(
        assessed, ladder=rungs, margins=margins, cases=cases, worst=worst, certificates=(), word=None
    )
    assert summary(poor)[0] == "No: by linear theory the loop is unstable on some branch of the hysteresis."
    assert summary(poor)[2].startswith("Open: ")
    said = details(poor)
    assert said[0] == (
        f"9 of 60 independent simulated single steps break the most critical requirement ({broken.words}): "
        f"7.1 to 27 % of cases at 95 % confidence, but a search of {worst.evaluations} runs for the worst "
        "scenario found none that breaks a limit."
    )
    where = f"{margins[0]['branch'].replace('line', 'line ')} ({margins[0]['rate']} rate)"
    assert said[1] == f"By linear theory the loop is unstable on {where} of the hysteresis."
    assert said[2] == ("No certificate was found for a loop that switches arbitrarily between branches.")


def test_a_limit_that_is_not_set_is_not_named(assessed):
    free = replace(assessed, limits=replace(assessed.limits, Ms=None, delay_margin_s=None))
    assert "limit" not in summary(free)[1]
    assert "limit" not in details(free)[1]
