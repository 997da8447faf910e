"""The page of a trace is one file that says what was found, on what evidence, and what is open."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from plants.effects.wrist.learnt_block import LearntBlock
from plants.measured.trace.search.description import Description, LearntCurve
from plants.measured.trace.search.rounds import SearchRound
from reports.shared.html import Made
from reports.shared.tables import fixed, number
from reports.trace.page import draw_all, shown_channels, trace_page
from reports.trace.parameter_figure import draw_parameters
from reports.trace.record import trace_record
from reports.trace.residual_figures import means, telling, thinned
from reports.trace.residual_words import depends
from reports.trace.search_figures import best_forms, drawn_forms
from reports.trace.tables import decision_table, parameter_table
from reports.trace.words import FEW, block_words, evidence, summary, verdict_sentence
from tests.reports.html_page import Page, summary_of
from tests.reports.report_samples import small_trace

pytestmark = pytest.mark.slow

BENT = "branch-curvature"


@pytest.fixture(scope="module")
def bent():
    return small_trace()


def stripped(trace, **changes):
    """The same trace with nothing added: effects were tried and did not help."""
    declared = {"effects": (), "revised": trace.fit.fitted, "after": trace.before}
    return replace(trace, after_interval=trace.before_interval, **{**declared, **changes})


@pytest.fixture(scope="module")
def unexplained(bent):
    """The same with the effect tried and not adopted, and something left."""
    regulator, wrist = bent.stages
    at = np.linspace(-20.0, 20.0, 60)
    learnt = Description(("angle_deg",), 0.4, (LearntCurve("angle_deg", at, 0.1 * np.sin(at)),))
    after = replace(wrist.before, depends_on=("angle_deg", "events"))
    left = replace(wrist, explained=False, description=learnt, after=after)
    return stripped(bent, verdict="unexplained", stages=(regulator, left), remarks=("Tried & dropped.",))


@pytest.fixture(scope="module")
def made(written_trace):
    return written_trace.made


@pytest.fixture(scope="module")
def text(written_trace):
    return written_trace.text


@pytest.fixture(scope="module")
def page(text):
    return Page(text)


def test_the_page_loads_nothing_from_elsewhere_and_its_links_lead_somewhere(page):
    tags = [t for t, _ in page.tags]
    assert not {"link", "iframe", "img", "object", "embed"} & set(tags)
    assert tags.count("script") == 1
    ids = [a["id"] for _, a in page.tags if "id" in a]
    assert len(ids) == len(set(ids))
    for _, attributes in page.tags:
        for key in ("src", "href", "xlink:href", "data"):
            target = attributes.get(key) or "#"
            assert target.startswith("#")
            assert target == "#" or target[1:] in ids


def test_it_opens_with_three_sentences_the_verdict_first(text, page, bent):
    opening = summary_of(text)
    assert len(opening) == 3
    assert opening == summary(bent)
    assert all(len(s.split()) <= 20 and s.endswith(".") for s in opening)
    before, after = (x["angle_deg"] for x in (bent.before, bent.after))
    assert f"falls from {number(before)} to {number(after)} deg" in opening[0]
    chi2 = bent.stages[1].search
    assert f"angle {chi2.declared.model.chi2:.2f} to {chi2.chosen.model.chi2:.2f}" in opening[1]
    few = len(bent.cannot_judge) <= FEW
    assert all(name in opening[2] for name in bent.cannot_judge) if few else "of 18 effects" in opening[2]
    said = verdict_sentence(bent)
    assert said.startswith("The branches of the loop are curved: with branch-curvature (")
    assert ") added, the angle error on the held-out recordings falls from " in said
    assert said in page.text  # in full, beneath the card


def test_it_shows_errors_evidence_parameters_and_provenance(page, bent):
    for name, p in bent.revised.parameters.items():
        assert name in page.text
        assert p.unit in page.text
    for words in (
        "On held-out blocks",
        f"Round 1, by held-out blocks: {BENT} selected",
        "Held out",
        "sine.csv",
        "conditional mean",
    ):
        assert words in page.text
    for name in bent.cannot_judge:
        assert name in page.text
    assert bent.campaign.checksum in page.text
    assert "Seed 7" in page.text
    assert "Synthetic" not in page.text
    assert "nan" not in re.findall(r"[a-z]+", page.text.lower())


def test_every_figure_has_data_labels_with_units_and_a_description(bent, page):
    drawn = draw_all(bent)
    assert {"errors", "fit-angle", "loop", "left-wrist", "left-regulator", "ranking-wrist"} <= set(drawn)
    assert sum(a.get("class") == "figure" for t, a in page.tags if t == "svg") == len(drawn)
    for name, figure in drawn.items():
        for axes in figure.axes:
            assert axes.lines or axes.patches or axes.collections, name
        labels = [x for a in figure.axes for x in (a.get_xlabel(), a.get_ylabel()) if x]
        assert labels, name
        assert all(re.search(r"\[.+\]", x) for x in labels), (name, labels)


def test_a_decision_in_what_looks_like_noise_is_told_by_its_likelihood(bent):
    search = bent.stages[1].search
    noise, other = search.chosen, search.declared
    assert not noise.examined.structured
    (group,) = decision_table((SearchRound(noise, (), (other,), None),)).groups
    assert group.heading == (
        "Round 1, by likelihood, since the residual looks like noise: nothing more selected"
    )
    blocks, gained = (group.rows[1][i].text for i in (2, 3))
    assert blocks == "–"
    assert gained == fixed(other.log_likelihood - noise.log_likelihood, 1)
    (group,) = decision_table((SearchRound(other, (), (noise,), noise),)).groups
    assert group.heading == f"Round 1, by held-out blocks: {BENT} selected"
    assert [cell.text for cell in group.rows[1][2:]] == [fixed(noise.held_out, 2), "–", "selected"]


def test_what_is_open_is_said_where_nothing_is(bent, unexplained):
    clear = replace(bent, stages=tuple(replace(s, cannot_judge={}) for s in bent.stages))
    assert summary(clear)[2].startswith("Each of the 18 effects would have shown in these recordings; ")
    said = summary(unexplained)
    assert len(said) == 3
    assert said[0].startswith("None of the 18 effects explains the residual")
    for few in (clear, unexplained):
        assert all(len(s.split()) <= 20 for s in summary(few))


def test_the_noise_is_drawn_where_the_errors_are_judged(bent):
    figure = draw_all(bent)["errors"]
    angle = next(a for a in figure.axes if a.get_title(loc="left") == "Angle")
    verticals = [line.get_xdata()[0] for line in angle.lines if line.get_linestyle() == "--"]
    assert verticals == [pytest.approx(bent.noise["angle_deg"])]


def test_the_pressure_is_drawn_over_time_only_where_something_was_found_in_it(bent):
    assert shown_channels(bent) == ["angle_deg"]
    regulator = replace(bent.stages[0], explained=False)
    assert shown_channels(replace(bent, stages=(regulator, bent.stages[1]))) == [
        "angle_deg",
        "pressure_kPa",
    ]


def test_what_no_effect_explains_is_described_and_not_called_a_cause(unexplained, made, no_pictures):
    text = Page(trace_page(unexplained, made)).text
    assert "Unexplained: of the angle" in text
    assert "% of the residual of the angle beyond noise" in text
    assert "a description, not a cause" in text.lower()
    assert "depends on the angle, and jumps at times" in text
    assert "Tried & dropped." in text
    assert f"With what was tried ({BENT})" in text


def test_the_record_says_what_is_left_and_on_what_it_depends(unexplained):
    record = trace_record(unexplained)
    left = record["unexplained"]
    assert (left["stage"], left["depends_on"]) == ("wrist", ["angle_deg", "events"])
    assert left["learnt"]["variables"] == ["angle_deg"]
    assert left["learnt"]["note"] == "a description, not a cause"
    assert "stages" not in left
    assert record["effects"] == []
    both = replace(unexplained, stages=tuple(replace(s, explained=False) for s in unexplained.stages))
    assert trace_record(both)["unexplained"]["stages"] == ["regulator", "wrist"]
    assert trace_record(both)["unexplained"]["stage"] == "regulator"


def test_parameters_of_a_law_that_was_chosen_stand_apart_from_those_of_effects(bent):
    fit = bent.fit
    own = {n: p for n, p in fit.fitted.parameters.items() if n != "a1"}  # which another law would not have
    chosen = replace(bent, fit=SimpleNamespace(fitted=SimpleNamespace(parameters=own)))
    groups = {g.heading: [r[0].text for r in g.rows] for g in parameter_table(chosen).groups}
    effects, law, declared = groups.values()
    assert {n.rpartition(".")[0] for n in effects} == {BENT}
    assert law == ["a1"]
    assert set(declared) == set(own)
    assert len(parameter_table(bent).groups) == 2


def test_the_record_holds_how_the_errors_of_its_parameters_correlate(bent):
    together = trace_record(bent)["correlation"]
    names = [n for c in together for n in c["parameters"]]
    fitted = {n: getattr(p.provenance, "std_error", None) for n, p in bent.revised.parameters.items()}
    assert sorted(names) == sorted(n for n, error in fitted.items() if error is not None)
    assert len(together) == 2  # the regulator, and the wrist with its effect
    for c in together:
        matrix = np.array(c["matrix"])
        np.testing.assert_allclose(np.diag(matrix), 1.0)
        np.testing.assert_allclose(matrix, matrix.T)
        assert np.linalg.eigvalsh(matrix).min() > -1e-3  # four decimals


def test_parameters_are_drawn_with_their_intervals_in_per_cent(bent):
    left = draw_parameters(bent).axes[0]
    drawn = {
        t.get_text().replace("\n", ""): b.get_width()
        for t, b in zip(left.get_yticklabels(), left.patches, strict=True)
    }
    # One that the recordings do not determine is at 0, of which there are no per cent.
    fitted = {n for c in bent.correlations for n in c.names}
    assert set(drawn) == {n for n in fitted if bent.revised.parameters[n].value != 0.0}
    for name, width in drawn.items():
        p = bent.revised.parameters[name]
        assert width == pytest.approx(100 * 1.96 * p.provenance.std_error / abs(p.value))
    assert draw_parameters(replace(bent, correlations=())) is None


def test_the_verdicts_read_well(bent, unexplained):
    nothing = stripped(bent, verdict="nothing-missing", before=bent.noise, after=bent.noise)
    said = verdict_sentence(nothing)
    assert said.startswith(
        "Nothing is missing: on the held-out recordings the RMSE of the declared model is "
    )
    assert "slow" not in said
    loud = verdict_sentence(replace(nothing, before=bent.before, after=bent.before))
    assert loud.endswith("; the residual of the angle has no more structure than slow noise.")
    left = verdict_sentence(unexplained)
    assert left.startswith(
        "The residual has structure that none of the 18 effects explains: the angle error on "
    )
    assert left.endswith("; the residual depends on the angle, and jumps at times.")
    part = replace(bent, verdict="unexplained")
    assert summary(part)[0].startswith(
        "Branch-curvature explains a part of the residual: held-out angle RMSE"
    )
    tied = replace(bent.effects[0], alternatives=("end-stop", "softening"))
    said = verdict_sentence(replace(bent, effects=(tied,)))
    assert said.endswith("; these recordings do not distinguish branch-curvature from end-stop or softening.")


def test_chi_squares_of_a_stage_are_of_one_kind_of_simulation(bent):
    """What was last fitted in a free run from the command leaves more under the measured pressure."""

    def model(measured, free):
        return SimpleNamespace(chi2=measured, forms=("creep",), freely=SimpleNamespace(chi2=free))

    (stage,) = (s for s in bent.stages if s.name == "wrist")
    for chosen, said in (
        (model(115.0, 9.0), "angle 90.00 to 9.00"),
        (model(3.0, 9.0), "angle 27.00 to 3.00"),
    ):
        search = SimpleNamespace(
            declared=SimpleNamespace(model=model(27.0, 90.0)), chosen=SimpleNamespace(model=chosen), rounds=[]
        )
        of_stage = SimpleNamespace(stage=stage.stage, search=search, model=chosen)
        assert said in evidence(replace(bent, stages=(of_stage,)))


def test_a_channel_that_was_not_logged_is_null(bent):
    def without(errors):
        return {**errors, "pressure_kPa": None}

    blind = replace(
        bent,
        before=without(bent.before),
        after=without(bent.after),
        fit=replace(bent.fit, noise=without(bent.noise)),
    )
    record = trace_record(blind)
    assert record["before"]["pressure_rmse_kPa"] is None
    assert record["noise_floor"] == {"angle_deg": bent.noise["angle_deg"], "pressure_kPa": None}
    assert len(draw_all(blind)["errors"].axes) == 1


def test_the_same_trace_makes_the_same_page(bent, made, text):
    assert trace_page(bent, made) == text


def test_a_remainder_of_a_hum_or_nothing_reads_well():
    assert depends(["periodic at 2.31 Hz"]) == "the residual is periodic at 2.31 Hz"
    assert (
        depends(["direction", "flow_l_min"])
        == "the residual depends on the direction of motion and flow_l_min"
    )


def test_the_most_telling_variables_come_first(bent):
    stage = bent.stages[1]
    found = telling(stage)
    assert 1 <= len(found) <= 4
    worst = max(
        (
            f
            for f in stage.before.findings
            if f.test == "conditional mean" and f.variable in stage.before.curves
        ),
        key=lambda f: f.statistic / f.bound,
    )
    assert found[0] == worst.variable


def test_means_in_bins_and_a_thinned_spectrum_keep_the_mean(bent):
    x = np.repeat(np.arange(10.0), 30)
    at, mean = means(x, 2.0 * x)
    np.testing.assert_allclose(mean, 2.0 * at)
    assert at.size == 10
    curve = bent.stages[1].before.curves["spectrum"]
    f, power = thinned(replace(curve, mean=np.ones_like(curve.mean)))
    np.testing.assert_allclose(power, 1.0)
    assert np.all(np.diff(f) > 0.0)


def test_what_a_round_selected_is_drawn_however_low_it_ranks(bent):
    first = bent.stages[1].search.rounds[0]
    turned = replace(first, ranking=first.ranking[::-1])
    names = [r.name for r in best_forms(turned.ranking)]
    assert names.index(BENT) > 3
    assert [r.name for r in drawn_forms(turned, 3)] == [*names[:3], BENT]
    assert [r.name for r in drawn_forms(replace(turned, taken=None), 3)] == names[:3]
    assert [r.name for r in drawn_forms(turned, None)] == names


def test_a_learnt_block_is_told_beside_the_causes_and_is_none(bent, no_pictures):
    values = {f"learnt.{n}": v for n, v in vars(LearntBlock(low=10.0, high=190.0, static3=0.4)).items()}
    revised = bent.revised.revised([LearntBlock], values, {}, "a rig")
    learnt = replace(bent, revised=revised, named_only={"angle_deg": 0.5, "pressure_kPa": 1.0}, learning=True)
    text = trace_page(learnt, Made.now("wrist trace <c>", 7, {"x": revised}, {"c": "0"}))
    (said,) = block_words(learnt)
    assert said.startswith("A learnt block, which names no cause, changes the angle error on the held-out")
    assert "from 0.5 to " in said
    assert "from 10 to 190 kPa" in said
    assert "Without the learnt block" in text
    assert said in text
    assert "learnt.static3" in text
    record = trace_record(learnt)["learnt_block"]
    assert record["range"] == {"from": 10.0, "to": 190.0, "unit": "kPa"}
    assert record["without"]["angle_rmse_deg"] == 0.5
    assert record["parameters"]["static3"] == 0.4
    assert [e["name"] for e in trace_record(learnt)["effects"]] == [e.name for e in bent.effects]
    assert block_words(replace(bent, learning=True)) == [
        "No learnt block: the angle has no residual that is left unexplained."
    ]
