"""What the tuner shows is what the loop does, and what python-control says of it."""

import numpy as np
import pytest

from design.controllers.pi import PI
from design.evaluation.scenarios import tuning_scenarios
from design.evaluation.steps import run
from design.margins import branch_responses
from design.open_loops import by_python_control
from design.synthesis.evaluate import out_of_range
from design.synthesis.requirements import Limits, Problem
from design.tuner.branch_margins import branch_margins
from design.tuner.case import case
from design.tuner.picture import picture, shown_samples
from design.tuner.setting import Setting, initial, plant
from plants import Wrist
from plants.effects import Creep, DeadTime, HardStop, TubeDeadTime

MOVED = Setting(Kp=4.0, Ki=15.0, width=1.3, lines=0.9, transit=1.5, dead_time=0.035)


def shown(wrist, setting, limits=None):
    return picture(case(wrist, setting, limits), setting)


@pytest.mark.parametrize("effects", [(), (Creep(0.1, 0.7),)], ids=["declared", "creeping"])
def test_every_series_is_a_run_of_the_loop_of_its_own(effects):
    wrist = Wrist.deviation()
    for effect in effects:
        wrist = wrist + effect
    moved = plant(wrist, MOVED)
    assert moved.hysteresis.w2 == 1.3 * wrist.hysteresis.w2
    assert moved.values["dead-time.delay"] == 0.035
    seen = shown(wrist, MOVED)
    assert {(s.case.task.start, s.case.task.reference) for s in seen.series} == {
        (start, sign * 15.0) for start in ("virgin", "line1", "line2", "inside") for sign in (1, -1)
    } | {("line1", 0.0), ("line2", 0.0)}
    for s in seen.series:
        task = s.case.task
        start = moved.rest(task.start, task.angle)
        judged, _, went = run(moved, PI(4.0, 15.0), task.reference, start, record=True)
        sign = 1.0 if task.reference > task.angle else -1.0
        rows = shown_samples(moved.rig)
        np.testing.assert_allclose(s.way, sign * (went.angle[rows, 0] - task.angle), atol=1e-9)
        np.testing.assert_allclose(s.command, went.command[rows, 0], atol=1e-9)
        assert s.settling_time_s == pytest.approx(float(judged.settling_time_s[0]), abs=1.1e-3)


@pytest.mark.parametrize("gains", [(1.2, 2.2), (4.0, 15.0), (9.0, 60.0)])
@pytest.mark.parametrize(
    "wrist",
    [
        Wrist.flexion(),
        Wrist.deviation() + DeadTime(0.02),
        Wrist.flexion() + TubeDeadTime(0.03, 0.02) + Creep(0.1, 0.7),
    ],
    ids=["declared", "late", "tube and creep"],
)
def test_margins_are_those_of_python_control(wrist, gains):
    theirs = by_python_control(wrist, PI(*gains))
    ours = branch_margins(branch_responses(wrist), PI(*gains))
    assert len(ours) == len(theirs)
    for a, b in zip(ours, theirs, strict=True):
        assert (a.branch, a.rate, a.stable) == (b["branch"], b["rate"], b["stable"])
        if a.stable:
            # A peak that is nearly a pole is narrower than a step of the grid.
            assert a.Ms == pytest.approx(b["Ms"], rel=2e-3) if b["Ms"] < 8.0 else a.Ms > 8.0
            for name in ("delay_margin_s", "phase_margin_deg"):
                assert getattr(a, name) == pytest.approx(b[name], rel=2e-3), name
            # Up to where dead time turns the phase faster than the grid of frequencies can follow.
            if b["gain_margin"] < 100.0:
                assert a.gain_margin == pytest.approx(b["gain_margin"], rel=1e-2)


def test_a_transit_without_slope_has_margins_without_end():
    first = shown(Wrist.flexion(), Setting(transit=0.0)).margins[0]
    assert (first.branch, first.gain_margin, first.delay_margin_s) == ("transit", np.inf, np.inf)


def test_limits_are_held_against_the_worst_of_what_is_drawn():
    seen = shown(Wrist.flexion(), Setting(Kp=4.0, Ki=20.0, dead_time=0.02))
    of = {row.name: row for row in seen.limits}
    assert of["overshoot_percent"].value == pytest.approx(max(s.overshoot_percent for s in seen.series))
    assert of["Ms"].value == pytest.approx(max(m.Ms for m in seen.margins), rel=1e-9)
    assert of["delay_margin_s"].value == pytest.approx(min(m.delay_margin_s for m in seen.margins), rel=1e-9)
    highest = max(s.way.max() for s in seen.series)
    assert of["overshoot_percent"].value == pytest.approx(100.0 * (highest / 15.0 - 1.0), abs=0.2)


@pytest.mark.parametrize("name", ["overshoot_percent", "Ms", "delay_margin_s", "total_variation_V"])
def test_a_limit_is_broken_on_one_side_of_its_value_only(name):
    setting = Setting(Kp=4.0, Ki=20.0, dead_time=0.02)
    value = {row.name: row.value for row in shown(Wrist.flexion(), setting).limits}[name]
    assert value > 0.0
    tight, loose = (0.99, 1.01) if name != "delay_margin_s" else (1.01, 0.99)
    nothing = dict.fromkeys(vars(Limits()))
    for factor, broken in ((tight, [name]), (loose, [])):
        limits = Limits(**{**nothing, name: factor * value})
        assert shown(Wrist.flexion(), setting, limits).broken == broken


def test_a_plant_that_is_none_says_why_and_shows_nothing():
    seen = shown(Wrist.flexion(), Setting(lines=0.5, transit=3.0))
    assert "runs backwards" in seen.trouble
    assert (seen.series, seen.limits) == ((), ())


@pytest.mark.parametrize(
    "wrist",
    [Wrist.flexion(), Wrist.flexion().with_values(gain=40.0), Wrist.deviation() + Creep(0.02, 0.7),
     Wrist.flexion() + HardStop(-11.0, 11.0)],
    ids=["in reach", "weak regulator", "creeping", "stopped"],
)  # fmt: skip
def test_what_is_out_of_reach_is_what_the_tuning_says(wrist):
    moved = plant(wrist, initial(wrist))
    problem = Problem.of(moved, [s for s in tuning_scenarios(moved) if s.plant == "nominal"])
    theirs, ours = out_of_range(problem), shown(wrist, initial(wrist)).note
    assert (ours is None) == (theirs is None)
    if theirs is not None and np.isfinite(theirs[1]):
        assert f"{theirs[1]:.3g} V too small" in ours
    elif theirs is not None:
        assert "keeps the wrist from" in ours
