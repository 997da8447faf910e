"""Captions begin with what a figure shows, in the numbers of the study that it is of."""

from dataclasses import replace

import numpy as np
import pytest

from design.comparison.compare import FORWARD, TUNED
from design.comparison.pareto import pareto_front
from reports.comparison import captions as comparison_captions
from reports.comparison.contest.table import MAIN, differences_caption
from reports.comparison.costs import break_even_caption, break_even_words
from reports.comparison.trade_off_figure import trade_off_caption
from reports.robustness import captions as robustness
from reports.shared.names import name_of
from reports.shared.tables import number
from reports.trace import captions as trace
from reports.trace.fit_figures import loop_run
from tests.reports.report_samples import (
    small_break_even,
    small_contest,
    small_fit,
    small_robustness,
    small_study,
    small_trace,
)


@pytest.mark.slow
def test_a_trade_off_names_the_pareto_front_of_each_motion():
    comparison = small_study().comparison
    said = trade_off_caption(comparison)
    assert said.startswith("Pareto front within the limits: ")
    for motion in {s.motion for s in comparison.standings}:
        front = pareto_front([s for s in comparison.standings if s.motion == motion])
        if front:
            assert f"{motion}: {', '.join(name_of(s.controller) for s in front)}" in said


@pytest.mark.slow
def test_the_fastest_feedback_within_the_limits_is_named_with_its_time():
    comparison = small_study().comparison
    said = comparison_captions.worst_caption(comparison)
    assert said.startswith("Fastest feedback within the limits: ")
    for motion in {s.motion for s in comparison.standings}:
        of = [s for s in comparison.standings if s.motion == motion and s.controller != FORWARD]
        able = [s for s in of if not s.breaks]
        if able:
            best = min(able, key=lambda s: s.worst_settling_s)
            assert f"{motion}: {name_of(best.controller)}, {best.worst_settling_s:.2f} s" in said
    assert said.endswith(comparison_captions.WORST_CAPTION)


@pytest.mark.slow
def test_a_map_of_the_gains_names_the_nearest_limit():
    study = small_study()
    assert study.tunings
    for motion, tuning in study.tunings.items():
        assert ", nearest to the limit on " in comparison_captions.map_caption(motion, tuning)


@pytest.mark.slow
def test_steps_say_when_the_controllers_in_colour_settle():
    comparison = small_study().comparison
    motions = {m for m, _ in comparison.steps}
    assert motions
    for motion in motions:
        (ours,) = [
            r
            for r in comparison.rows
            if (r.motion, r.controller, r.task_id) == (motion, TUNED, "step+virgin")
        ]
        said = comparison_captions.steps_caption(comparison, motion)
        assert f"{name_of(TUNED)} settles in {ours.metrics['settling_time_s']:.2f} s" in said


@pytest.mark.slow
def test_the_loop_says_how_long_its_dead_zone_takes():
    """The pressure crosses half of the loop's width at the level of the rest angle before the angle moves."""
    study = small_study()
    said = comparison_captions.loops_caption(study.comparison)
    for motion, wrist in study.question.wrists.items():
        loop = wrist.hysteresis
        width = abs(float(loop.ascending_pressure(0.0)) - float(loop.rest_pressure))
        told = float(said.split(f"{motion}: ")[1].split(" kPa")[0])
        assert abs(told - width) < 0.05 * width + 0.5


def test_a_fit_gives_its_error_before_and_after():
    fit = small_fit("flexion")
    said = comparison_captions.fit_caption("flexion", fit)
    run = fit.runs[1]
    before, after = (
        float(np.sqrt(np.mean((a - run.recording.angle) ** 2))) for a in (run.angle_before, run.angle)
    )
    assert f"RMSE {number(before)} deg before the fit, {number(after)} deg after. " in said


def test_the_break_even_map_begins_with_where_it_is():
    maps = small_break_even()
    assert maps
    for motion, found in maps.items():
        said = break_even_caption(motion, found)
        assert said.startswith(break_even_words(motion, found))


@pytest.mark.slow
def test_the_contest_counts_who_has_less_error():
    found = small_contest()
    nominal = small_study().comparison
    said = differences_caption(found, nominal)
    for motion in ("flexion", "deviation"):
        others = [s for s in found.of(motion, *MAIN) if s.controller != TUNED]
        less = [s.controller for s in others if s.against["iae_deg_s"].high < 0.0]
        assert f"{motion}: {len(less)} of {len(others)} controllers" in said


@pytest.mark.slow
def test_the_contest_says_which_of_these_break_a_limit():
    found, nominal = small_contest(), small_study().comparison
    worse = replace(found.scores[0].against["iae_deg_s"], low=-2.0, high=-1.0)
    ahead = [
        replace(s, against={**s.against, "iae_deg_s": worse}) if s.controller != TUNED else s
        for s in found.scores
    ]
    standings = [replace(s, breaks=("Ms",)) if s.controller == "paper" else s for s in nominal.standings]
    said = differences_caption(replace(found, scores=ahead), replace(nominal, standings=standings))
    assert f"flexion: 1 of 1 controllers ({name_of('paper')} breaks limits)" in said


@pytest.mark.slow
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


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_errors_of_a_trace_stand_before_and_after():
    found = small_trace()
    said = trace.errors(found)
    assert (
        f"{number(found.before['angle_deg'])} deg before, {number(found.after['angle_deg'])} deg after"
        in said
    )
    calm = [s for s in found.stages if not s.before.structured]
    assert calm
    for stage in calm:
        assert "no structure beyond noise" in trace.remainder(stage, "the revised wrist")
    run = loop_run(found)
    first = run.recording.time <= run.recording.time[0] + 20.0
    far = float(np.abs(run.angle_before - run.recording.angle)[first].max())
    assert trace.loop(found).startswith(f"Largest error of the angle: declared {number(far)} deg")
    (stage, *_) = found.stages
    chosen = [r.taken for r in stage.search.rounds if r.taken is not None]
    first = trace.ranking(stage).split(". ")[0]
    assert first == (f"Selected: {', '.join(chosen[-1].model.effects)}" if chosen else "Nothing was selected")
