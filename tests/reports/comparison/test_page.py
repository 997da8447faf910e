"""The page of a comparison is one file that says everything; JSON and CSV say the same in numbers."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

from design.alternatives.lqi_design import RobustLQI
from design.comparison.compare import row_record
from design.studies.study import Question, Study
from design.synthesis.requirements import Limits
from plants import InputError, built_in
from plants.effects import DeadTime
from plants.files import json_text
from reports.comparison.contest.words import sentences
from reports.comparison.costs import break_even_words, ledger_words
from reports.comparison.designs import designs
from reports.comparison.page import comparison_page, write_comparison
from reports.comparison.record import comparison_record
from reports.comparison.verdict_words import verdict_sentences
from reports.shared.glossary import GLOSSARY
from reports.shared.html import Made, commit, render
from reports.shared.names import name_of
from reports.shared.tables import number
from tests.reports.html_page import Page, summary_of
from tests.reports.report_samples import (
    small_break_even,
    small_contest,
    small_decision,
    small_ledgers,
    small_study,
    whole_study,
)

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def compared() -> Study:
    return small_study()


@pytest.fixture(scope="module")
def made(written_comparison):
    return written_comparison.made


@pytest.fixture(scope="module")
def folder(written_comparison):
    assert written_comparison.path.name == "comparison.html"
    return written_comparison.path.parent


@pytest.fixture(scope="module")
def page(written_comparison):
    return Page(written_comparison.text)


@pytest.fixture
def plain(compared, made, no_pictures):
    """The page of a study without perturbed plants and break-even."""
    return comparison_page(compared, made)


def test_the_figure_behind_dead_time_says_what_was_played(folder):
    text = (folder / "comparison.html").read_text(encoding="utf-8")
    assert text.count("Worst overshoot of every controller against added dead time") >= 1
    assert "for an MPC from rest only" in text


def test_the_page_loads_nothing_from_elsewhere(page):
    tags = [t for t, _ in page.tags]
    assert not {"link", "iframe", "img", "object", "embed"} & set(tags)
    assert tags.count("script") == 2  # of curves, and of cells of gain maps
    for _, attributes in page.tags:
        for key in ("src", "href", "xlink:href", "data"):
            assert (attributes.get(key) or "#").startswith("#")
    styles = "".join(page.words)
    assert "@import" not in styles
    assert "url(http" not in styles


def test_links_within_the_page_lead_somewhere_and_ids_are_unique(page):
    ids = [a["id"] for _, a in page.tags if "id" in a]
    assert len(ids) == len(set(ids))
    used = {a[k][1:] for _, a in page.tags for k in ("href", "xlink:href") if a.get(k)}
    assert used <= set(ids)


def test_the_page_names_every_controller_limit_task_and_assumption(page, compared):
    names = ("recommended PI", "paper's PI (stand-in)", "SIMC", "AMIGO", "Ziegler-Nichols")
    for words in (*names, "convex-concave PI", "robust LQI"):
        assert words in page.text
    for words in ("Overshoot", "Ms", "Delay margin", "return from −15 to 0 deg", "0 to +15 deg, from virgin"):
        assert words in page.text
    for s in compared.plants.values():
        for name in s.assumed:
            assert s.parameters[name].provenance.why in page.text


def test_the_page_tells_how_the_other_designs_were_found(page, compared):
    for (_, name), d in compared.comparison.designs.items():
        assert f"{name[:1].upper()}{name[1:]}:" in page.text
        assert number(float(d.at.cost[0])) in page.text
    for words in ("convex programs", "active: ", "observer", "designed separately", "every limit met"):
        assert words in page.text


def test_a_design_that_is_lacking_or_breaks_a_limit_is_said_so(compared):
    (key, lqi), *_ = (kd for kd in compared.comparison.designs.items() if isinstance(kd[1], RobustLQI))
    beyond = replace(lqi, at=replace(lqi.at, excess={**lqi.at.excess, "noise_gain": np.array([0.3])}))
    shown = replace(
        compared.comparison, designs={key: beyond, (key[0], "convex-concave PI"): "no solver came to an end"}
    )
    said = " ".join(designs(shown, key[0]))
    assert "it breaks the noise gain." in said
    assert "Convex-concave PI: none: no solver came to an end." in said


def test_a_revised_set_is_given_not_declared(compared, made, page, no_pictures):
    c = compared
    revised = c.plants["flexion"].revised([DeadTime], {"dead-time.delay": 0.05}, {}, "rig 7")
    question = Question({**c.plants, "flexion": revised})
    text = Page(comparison_page(replace(c, question=question), made)).text
    assert f"{revised.title}. No recordings were given for this motion: the parameters are as given." in text
    declared = (
        f"{c.plants['deviation'].title}. No recordings were given for this motion: the parameters are as "
    )
    assert f"{declared}declared." in page.text


def test_the_page_opens_with_the_answer_in_three_short_sentences(folder, page):
    opening = summary_of((folder / "comparison.html").read_text(encoding="utf-8"))
    d = small_decision()
    broken, total = (
        sum(d.evidence[k][n] for k, n in (("samples", a), ("worst_case", b)))
        for a, b in (("broken", "broken"), ("total", "runs"))
    )
    assert len(opening) == 3
    assert all(len(s.split()) <= 20 and s.endswith(".") for s in opening)
    if broken:
        assert f"break a limit in {broken} of {total} simulated runs with up to 50 ms" in opening[0]
    else:
        assert opening[0].startswith("These gains ")
    assert "A stability proof is open" in opening[2]
    assert f"flexion {name_of(d.controller)} {number(d.gains['Kp'])} {number(d.gains['Ki'])}" in page.text
    assert ("No PI tried meets every limit" in page.text) is not d.holds


def test_the_decision_is_the_candidate_that_breaks_limits_least():
    d = small_decision()
    share = {n: c["samples_broken"] for n, c in d.candidates.items()}
    assert set(share) == {"tuned", "robust PI"}
    assert share[d.controller] == min(share.values())
    assert d.evidence["proved"]["status"] == "open"
    assert [r["limit"] for r in d.matrix] == list(Limits.of(built_in("flexion").rig).named)


def test_the_card_has_a_mark_for_every_value_that_is_judged(page):
    rows = small_decision().matrix
    judged = [v for r in rows for v in r["held"].values() if v is not None]
    cells = [a.get("class") or "" for t, a in page.tags if t == "td"]
    assert sum("met" in c.split() for c in cells) == sum(judged)
    assert sum("broken" in c.split() for c in cells) >= len(judged) - sum(judged)


def test_terms_carry_their_definition(page):
    titles = {a["title"] for t, a in page.tags if t == "abbr"}
    assert GLOSSARY["delay margin"] in titles
    assert titles <= set(GLOSSARY.values())


def test_figures_of_the_comparison_are_inside_and_the_papers_on_a_page_of_their_own(folder, page):
    def figures(p):
        return [a for t, a in p.tags if t == "svg" and a.get("class") == "figure"]

    # card, steps, trade-off, worst and loops, dead time, map, fit, differences, break-even
    assert len(figures(page)) == 1 + 2 + 3 + 1 + 1 + 1 + 1 + 1
    assert all(a.get("aria-label") and "viewbox" in a for a in figures(page))
    paper = Page((folder / "paper.html").read_text(encoding="utf-8"))
    assert len(figures(paper)) == 9
    assert paper.text.count("of the paper, redrawn:") == 9


def test_times_beyond_the_window_are_said_to_be_beyond_it(page):
    assert "> 10" in page.text
    assert "inf" not in {w.strip() for w in page.words}
    assert "nan" not in page.text.lower().split()


def test_the_fit_is_shown_with_errors_of_the_parameters_and_of_the_model(page):
    assert "0.3780 ± 0.0020" in page.text
    assert "6.3 ± unknown" in page.text
    assert (
        "Errors exceed the noise, the angle by 6 times: the model lacks something that this rig has."
        in page.text
    )


def test_the_footer_says_what_made_the_page(page, compared):
    for words in ("wrist compare a&b <c>", "0123456789abcdef" * 4, "Seed 7", "The recordings are synthetic."):
        assert words in page.text
    for s in compared.plants.values():
        assert s.title in page.text


def test_what_being_better_costs_stands_on_the_page_and_in_json(page, folder):
    for said in (break_even_words("flexion", small_break_even()["flexion"]), ledger_words(small_ledgers())):
        assert said in page.text
    for words in ("no guarantee of a deadline", "fewer than 10 plants give neither interval nor rank"):
        assert words in page.text
    record = json.loads((folder / "comparison.json").read_text(encoding="utf-8"))
    rows = {(r["kind"], r["controller"], r["metric"]): r for r in record["break_even"]["flexion"]}
    high = small_break_even()["flexion"].of("loop width", "feedforward").break_even("IAE")[1]
    assert rows["loop width", "feedforward", "IAE"]["break_even_high"] == pytest.approx(high)
    assert record["ledger"]["flexion"]["linear MPC"]["total_s"]["p99"] == pytest.approx(1e-4)


def test_csv_agrees_with_the_rows(folder, compared):
    with (folder / "comparison.csv").open(newline="", encoding="utf-8") as file:
        found = list(csv.DictReader(file))
    rows = [row_record(r) for r in compared.comparison.rows]
    assert len(found) == len(rows)
    for got, expected in zip(found, rows, strict=True):
        assert list(got) == list(expected)
        for key, value in expected.items():
            if isinstance(value, str):
                assert got[key] == value
            else:
                assert got[key] == "" if value is None else float(got[key]) == value


def test_the_broad_comparison_stands_on_the_page_with_its_intervals_and_ties(page):
    for s in sentences(small_contest()):
        assert s[1:] in page.text
    for words in (
        "perturbed plants, steps (12 plants)",
        "coupled, 0.02 deg/kPa",
    ):
        assert words in page.text
    i = small_contest().of("flexion", "perturbed plants", "steps")[1].against["iae_deg_s"]
    assert f"+{i.mean:.2f} {i.low:.2f} to {i.high:.2f}" in page.text


def test_the_contest_in_csv_is_that_in_json(folder):
    with (folder / "contest.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    scores = json.loads((folder / "comparison.json").read_text(encoding="utf-8"))["contest"]["scores"]
    assert len(rows) == len(scores)
    for got, expected in zip(rows, scores, strict=True):
        for key, value in expected.items():
            same = got[key] == ("" if value is None else value) if isinstance(value, str | None) else None
            assert same if same is not None else float(got[key]) == value


def test_without_a_contest_the_page_does_without(compared, made, plain):
    text = Page(plain).text
    assert "Perturbed plants with a noisy sensor" not in text
    assert comparison_record(compared, made)["contest"] is None


def test_ratios_to_the_lower_bound_stand_beside_every_controller(page, compared):
    assert "Settling / bound" in page.text
    for s in compared.comparison.standings:
        shown = f"{s.worst_iae_ratio:.2f}" if s.worst_iae_ratio < 10.0 else f"{s.worst_iae_ratio:.1f}"
        assert shown in page.text


def test_json_agrees_with_the_comparison(folder, compared, made):
    found = json.loads((folder / "comparison.json").read_text(encoding="utf-8"))
    c = compared
    record = comparison_record(whole_study(), made)
    assert found == json.loads(json_text(record))
    assert found["rows"] == [row_record(r) for r in c.comparison.rows]
    assert found["verdicts"] == verdict_sentences(c)
    assert [s["Kp"] for s in found["standings"]] == [s.Kp for s in c.comparison.standings]
    assert found["tunings"]["flexion"]["Ki"] == c.tunings["flexion"].Ki
    assert found["fits"]["flexion"]["parameters"]["a1"]["std_error"] == 0.002
    assert found["made"]["seed"] == 7


def test_pictures_lie_beside_the_page_and_nothing_half_written(folder):
    names = {p.name for p in folder.iterdir()}
    pictures = {
        "steps-flexion.png", "steps-deviation.png", "dead-time.png", "gains-flexion.png", "fit-flexion.png",
        "loops.png", "worst-values.png", "trade-off.png", "differences.png", "decision.png", "paper.html",
        "break-even-flexion.png",
    }  # fmt: skip
    assert names == pictures | {"comparison.html", "comparison.json", "comparison.csv", "contest.csv"}
    assert all((folder / p).read_bytes().startswith(b"\x89PNG") for p in pictures if p.endswith("png"))


def test_the_same_comparison_makes_the_same_page(written_comparison):
    assert comparison_page(whole_study(), written_comparison.made) == written_comparison.text


def test_a_place_that_cannot_be_written_to_is_said(compared, made, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        write_comparison(tmp_path / "file" / "in", compared, made)


def test_outside_a_checkout_no_commit_is_claimed(tmp_path):
    assert commit(tmp_path) == "not in a checkout"


def test_a_template_that_lacks_content_is_an_error_not_a_blank():
    import jinja2

    with pytest.raises(jinja2.UndefinedError):
        render("comparison.html", title="only this")


def test_a_rig_with_one_motion_has_a_page_of_its_own_and_none_of_the_papers_figures(compared, plain):
    comparison = replace(
        compared.comparison,
        rows=tuple(r for r in compared.comparison.rows if r.motion == "flexion"),
        standings=tuple(s for s in compared.comparison.standings if s.motion == "flexion"),
        steps={k: t for k, t in compared.comparison.steps.items() if k[0] == "flexion"},
    )
    question = Question({"flexion": compared.plants["flexion"]})
    late = {"flexion": compared.late["flexion"]}
    alone = replace(compared, question=question, comparison=comparison, redrawn={}, late=late)
    page = Page(comparison_page(alone, Made.now("wrist compare", 7, question.plants)))
    assert "eviation" not in page.text.replace("standard deviation", "")
    assert "in both motions" not in page.text
    assert "in both motions" in Page(plain).text
    assert len(verdict_sentences(alone)) == 1
