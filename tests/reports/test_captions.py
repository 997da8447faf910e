"""Captions begin with what a figure shows, in the numbers of the study that it is of."""

import pytest

from design.comparison.compare import FORWARD, TUNED
from design.comparison.pareto import pareto_front
from reports.comparison import words as comparison_words
from reports.comparison.contest import MAIN, differences_caption
from reports.comparison.trade_off_figure import trade_off_caption
from reports.robustness import captions as robustness
from reports.shared.names import name_of
from reports.shared.tables import number
from reports.trace import captions as trace
from tests.reports.report_samples import small_contest, small_robustness, small_study, small_trace


def test_a_trade_off_names_the_pareto_front_of_each_motion():
    comparison = small_study().comparison
    said = trade_off_caption(comparison)
    assert said.startswith("Pareto front within the limits: ")
    for motion in {s.motion for s in comparison.standings}:
        front = pareto_front([s for s in comparison.standings if s.motion == motion])
        if front:
            assert f"{motion}: {', '.join(name_of(s.controller) for s in front)}" in said


def test_the_fastest_feedback_within_the_limits_is_named_with_its_time():
    comparison = small_study().comparison
    said = comparison_words.worst_caption(comparison)
    assert said.startswith("Fastest feedback within the limits: ")
    for motion in {s.motion for s in comparison.standings}:
        of = [s for s in comparison.standings if s.motion == motion and s.controller != FORWARD]
        able = [s for s in of if not s.breaks]
        if able:
            best = min(able, key=lambda s: s.worst_settling_s)
            assert f"{motion}: {name_of(best.controller)}, {best.worst_settling_s:.2f} s" in said
    assert said.endswith(comparison_words.WORST_CAPTION)


def test_a_map_of_the_gains_names_the_nearest_limit():
    study = small_study()
    assert study.tunings
    for motion, tuning in study.tunings.items():
        assert ", nearest to the limit on " in comparison_words.map_caption(motion, tuning)


def test_the_contest_counts_who_has_less_error():
    found = small_contest()
    said = differences_caption(found)
    for motion in ("flexion", "deviation"):
        others = [s for s in found.of(motion, *MAIN) if s.controller != TUNED]
        less = sum(s.against["iae_deg_s"].high < 0.0 for s in others)
        assert f"{motion}: {less} of {len(others)} controllers" in said


def test_figures_of_the_linear_loop_give_their_extremes():
    a = small_robustness().assessment
    Ms = max(a.margins, key=lambda m: m["Ms"])
    assert f"Ms {number(Ms['Ms'])}. " in robustness.nyquist_caption(a)
    assert f"at the {Ms['rate']} rate" in robustness.nyquist_caption(a)
    phase = min(m["phase_margin_deg"] for m in a.margins)
    assert robustness.bode_caption(a).startswith(f"Smallest phase margin: {number(phase)} deg on ")
    assert f"|T| {number(max(m['Mt'] for m in a.margins))}. " in robustness.sensitivities_caption(a)
    assert robustness.describing_caption(a).startswith("A limit" if a.cycles else "No limit cycle")
    over = a.cases.metrics.overshoot_percent[~a.cases.out_of_reach]
    assert robustness.envelope_caption(a).startswith(
        f"Largest overshoot of {over.size} cases: {number(float(over.max()))} %"
    )


@pytest.mark.filterwarnings("ignore")
def test_errors_of_a_trace_stand_before_and_after():
    found = small_trace()
    said = trace.errors(found)
    assert (
        f"{number(found.before['angle_deg'])} deg before, {number(found.after['angle_deg'])} deg after"
        in said
    )
    (stage, *_) = found.stages
    chosen = [r.taken for r in stage.search.rounds if r.taken is not None]
    first = trace.ranking(stage).split(". ")[0]
    assert first == (f"Selected: {', '.join(chosen[-1].model.effects)}" if chosen else "Nothing was selected")
