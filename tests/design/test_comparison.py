"""The comparison is complete, carries the doubt about the paper's gains, and ranks nothing within it."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from design.alternatives.designs import CONVEX, FORWARD_PI, LQI_NAME, design_others, design_record
from design.comparison.compare import (
    FORWARD,
    METRICS,
    PAPER,
    TUNED,
    Comparison,
    Row,
    compare,
    on_tasks,
    row_record,
    step_cases,
    together,
)
from design.comparison.tolerated import tolerated
from design.controllers.controller import settings_of
from design.controllers.pi import PI
from design.evaluation.metrics import Metrics
from design.evaluation.steps import run
from design.mpc import loop
from design.mpc.formulations.linear import linear_mpc
from design.mpc.margins_at_rest import margins_at_rest
from design.mpc.problem import MPCProblem as Problem_of_MPC
from design.open_loops import by_python_control
from design.synthesis.requirements import Limits, Problem
from design.synthesis.tuning_rules import baselines, paper_range
from plants import Wrist
from plants.effects import Creep, DeadTime
from tests.reports.report_samples import QUICK

pytestmark = pytest.mark.slow

WRISTS = {"flexion": Wrist.flexion(), "deviation": Wrist.deviation()}
GAINS = {"flexion": PI(3.0, 9.0), "deviation": PI(6.0, 18.0)}
NAMES = {TUNED, PAPER, "SIMC", "AMIGO", "Ziegler-Nichols", CONVEX, LQI_NAME, FORWARD_PI, FORWARD}
DESIGNS = (CONVEX, LQI_NAME, FORWARD_PI)


@cache
def designs() -> dict[str, dict]:
    """The other designs of both motions, made on the tasks alone."""
    return {
        m: design_others(Problem.of(w, step_cases(w), duration=5.0), makers=QUICK) for m, w in WRISTS.items()
    }


@cache
def both() -> Comparison:
    return compare(WRISTS, GAINS, designs=designs())


@pytest.fixture
def comparison() -> Comparison:
    return both()


def row(comparison: Comparison, motion: str, task: str, controller: str) -> Row:
    (found,) = (r for r in comparison.rows if (r.motion, r.task, r.controller) == (motion, task, controller))
    return found


def test_every_controller_is_run_on_every_task_of_every_motion_once(comparison):
    tasks = {f"0 to {s:+d} deg, {m}" for s in (15, -15) for m in ("virgin", "line1", "line2", "inside")}
    tasks |= {"return from +15 to 0 deg", "return from -15 to 0 deg"}
    alone = {(m, t, c) for m in WRISTS for t in tasks for c in NAMES}
    together_ = {("both at once", f"0 to {s:+d} deg, virgin", c) for s in (15, -15) for c in NAMES}
    assert len(comparison.rows) == len(alone | together_)
    assert {(r.motion, r.task, r.controller) for r in comparison.rows} == alone | together_


def test_every_controller_has_a_standing_and_a_step_to_draw(comparison):
    pairs = {(m, c) for m in WRISTS for c in NAMES}
    assert {(s.motion, s.controller) for s in comparison.standings} == pairs
    assert set(comparison.steps) == pairs


def test_the_range_of_the_paper_encloses_the_stand_in(comparison):
    wide = 0
    for r in comparison.rows:
        if r.controller == PAPER:
            assert all(r.low[n] <= r.metrics[n] <= r.high[n] for n in METRICS)
            wide += sum(r.low[n] < r.high[n] for n in METRICS)
    assert wide > 100


def test_the_range_is_that_of_the_five_pairs_of_gains(comparison):
    w = WRISTS["deviation"]
    runs = [run(w, PI(*g), -15.0, w.rest("line1"))[0] for g in paper_range()]
    found = row(comparison, "deviation", "0 to -15 deg, line1", PAPER)
    for n in METRICS:
        values = [float(getattr(m, n)[0]) for m in runs]
        assert (found.metrics[n], found.low[n], found.high[n]) == (values[0], min(values), max(values))


def test_what_is_known_has_no_range(comparison):
    for r in comparison.rows:
        if r.controller != PAPER:
            assert r.low == r.high == r.metrics


@pytest.mark.parametrize("motion", WRISTS)
def test_a_row_is_the_run_that_it_names(comparison, motion):
    w = WRISTS[motion]
    others = {n: d.controller for n, d in designs()[motion].items()}
    for name, pi in {**baselines(w), TUNED: GAINS[motion], **others}.items():
        for s in step_cases(w)[::3]:
            judged, _, _ = run(w, pi, s.task.reference, w.rest(s.task.start, s.task.angle))
            found = row(comparison, motion, f"0 to {s.task.reference:+g} deg, {s.task.start}", name)
            assert found.metrics == {n: float(getattr(judged, n)[0]) for n in METRICS}


def test_a_return_starts_from_where_five_seconds_of_holding_have_led():
    w, pi = WRISTS["flexion"], PI(1.2, 2.2)
    (found,) = on_tasks(w, [pi])["return-"]
    _, held, _ = run(w, pi, -15.0, duration=5.0)
    _, _, t = run(w, pi, 0.0, held.plant, held.controller, record=True)
    assert float(t.angle[0, 0]) == float(held.plant.angle[0])
    assert float(found.iae_deg_s) == pytest.approx(float(np.abs(t.angle[:-1, 0]).sum()) * 1e-3, rel=1e-9)


def test_both_at_once_is_the_later_the_larger_and_the_sum(comparison):
    for sign in ("+", "-"):
        task = f"0 to {sign}15 deg, virgin"
        for name in NAMES - {PAPER}:
            one, other = (row(comparison, m, task, name).metrics for m in WRISTS)
            found = row(comparison, "both at once", task, name).metrics
            for n in ("rise_time_s", "settling_time_s", "overshoot_percent", "steady_state_error_deg"):
                assert found[n] == max(one[n], other[n])
            for n in ("iae_deg_s", "ise_deg2_s", "itae_deg_s2", "total_variation_V"):
                assert found[n] == one[n] + other[n]


def test_one_that_never_settles_keeps_both_from_settling():
    quick = Metrics(0.1, 0.2, 1.0, 0.0, 1.0, 1.0, 1.0, 1.0)
    slow = replace(quick, settling_time_s=np.inf)
    assert together(quick, slow).settling_time_s == np.inf == together(slow, quick).settling_time_s


def test_one_motion_alone_has_no_rows_for_both():
    found = compare({"flexion": WRISTS["flexion"]}, {"flexion": GAINS["flexion"]}, designs={})
    assert {r.motion for r in found.rows} == {"flexion"}


def test_standings_tell_which_limits_are_broken(comparison):
    for s in comparison.standings:
        broken = {
            "overshoot_percent": s.worst_overshoot_percent > 5.0,
            "Ms": s.Ms > 2.0,
            "delay_margin_s": s.delay_margin_s < 0.060,
        }
        assert {n for n in s.breaks if n in broken} == {n for n, is_broken in broken.items() if is_broken}
    assert any(s.breaks for s in comparison.standings)


def test_no_controller_beats_the_lower_bound_of_any_task(comparison):
    for r in comparison.rows:
        assert r.settling_ratio >= 1.0
        assert r.iae_ratio >= 1.0


@pytest.mark.parametrize("start", ["virgin", "line1", "line2", "inside"])
def test_a_ratio_is_the_metric_over_the_bound_of_full_throttle(comparison, start):
    w = WRISTS["deviation"]
    found = row(comparison, "deviation", f"0 to +15 deg, {start}", TUNED)
    angle = w.simulate([4.0] * 3000, w.rest(start)).angle
    first = int(np.argmax(angle > 15.0 * 0.98))
    assert found.settling_ratio == pytest.approx(found.metrics["settling_time_s"] / (first * 1e-3), rel=0.02)
    least = float(np.maximum(15.0 - angle[:-1], 0.0).sum()) * 1e-3
    assert found.iae_ratio == pytest.approx(found.metrics["iae_deg_s"] / least, rel=1e-6)


def test_standings_carry_the_worst_ratios_over_the_tasks(comparison):
    for s in comparison.standings:
        own = [r for r in comparison.rows if (r.motion, r.controller) == (s.motion, s.controller)]
        assert s.worst_settling_ratio == max(r.settling_ratio for r in own)
        assert s.worst_iae_ratio == max(r.iae_ratio for r in own)


def test_a_wrist_without_a_known_bound_has_no_ratios():
    w = WRISTS["flexion"] + Creep(-0.05, 5.0)
    found = compare({"flexion": w}, {"flexion": GAINS["flexion"]}, designs={})
    assert {(r.settling_ratio, r.iae_ratio) for r in found.rows} == {(None, None)}
    assert FORWARD not in {s.controller for s in found.standings}  # nor an inverse


def test_a_feedforward_adds_nothing_to_the_loop_that_margins_are_of(comparison):
    for s in comparison.standings:
        if s.controller == FORWARD:
            assert (s.Ms, s.delay_margin_s) == (1.0, np.inf)
        if s.controller == FORWARD_PI:
            w = WRISTS[s.motion]
            rows = by_python_control(w, PI(s.Kp, s.Ki, w.regulator.gain, w.hysteresis.rest_pressure))
            assert s.Ms == max(r["Ms"] for r in rows)


def test_an_MPC_stands_in_the_table_with_margins_at_rest_and_what_it_tolerates():
    w = WRISTS["deviation"]
    mpc = linear_mpc(Problem_of_MPC(w))
    found = compare(
        {"deviation": w}, {"deviation": GAINS["deviation"]}, designs={}, periodic={"deviation": {"MPC": mpc}}
    )
    (s,) = (s for s in found.standings if s.controller == "MPC")
    at_rest = margins_at_rest(mpc, [w])
    assert (s.Ms, s.delay_margin_s) == (at_rest.Ms, at_rest.delay_margin_s)
    assert s.delay_margin_s == pytest.approx(s.tolerated_delay_s, abs=0.01)  # of two ways to ask
    late = [
        loop.run(w + DeadTime(s.tolerated_delay_s + more), mpc, 15.0, duration=5.0) for more in (0.0, 5e-3)
    ]
    assert [bool(np.isfinite(x.metrics.settling_time_s[0])) for x in late] == [True, False]
    assert "delay_margin_s" in s.breaks  # at least 60 ms is asked for
    assert s.settings["horizon"] == 30.0
    assert s.settings["weights.move"] == mpc.problem.weights.move
    rows = [r for r in found.rows if r.controller == "MPC"]
    assert len(rows) == 10
    assert all(r.settling_ratio >= 1.0 and r.iae_ratio >= 1.0 for r in rows)
    played = loop.run(w, mpc, -15.0, w.rest("line2"))
    found_ = row(found, "deviation", "0 to -15 deg, line2", "MPC")
    assert found_.metrics == {n: float(getattr(played.metrics, n)[0]) for n in METRICS}
    assert ("deviation", "MPC") in found.steps


def test_without_limits_none_is_broken():
    none = Limits.none()
    found = compare({"flexion": WRISTS["flexion"]}, {"flexion": GAINS["flexion"]}, none, designs={})
    assert not any(s.breaks for s in found.standings)


def test_the_other_designs_stand_in_the_table_with_the_settings_that_they_have(comparison):
    for s in comparison.standings:
        if s.controller in (LQI_NAME, FORWARD):
            assert (s.Kp, s.Ki) == (None, None)
        else:
            assert (s.Kp, s.Ki) == (s.settings["Kp"], s.settings["Ki"])
        assert bool(s.design) == (s.controller in DESIGNS)
        if s.design:
            assert s.settings == settings_of(designs()[s.motion][s.controller].controller)
            assert s.design["breaks"] == []
            assert not s.breaks


def test_a_design_that_cannot_be_made_is_lacking_with_its_reason():
    w = WRISTS["flexion"]
    strict = Limits(Ms=0.9)
    others = design_others(Problem.of(w, step_cases(w)[:2], strict, duration=3.0), makers=QUICK)
    assert others[CONVEX] == "Ms = 0.9: a peak of a sensitivity is limited to more than 1"
    assert design_record(others[CONVEX]) == {"none": others[CONVEX]}
    found = compare({"flexion": w}, {"flexion": GAINS["flexion"]}, strict, designs={"flexion": others})
    names = {s.controller for s in found.standings}
    assert CONVEX not in names
    assert LQI_NAME in names
    (lqi,) = (s for s in found.standings if s.controller == LQI_NAME)
    assert "Ms" in lqi.breaks
    assert "Ms" in lqi.design["breaks"]


def test_a_record_is_flat_and_has_no_infinity(comparison):
    r = row(comparison, "flexion", "0 to +15 deg, virgin", PAPER)
    record = row_record(replace(r, high={**r.high, "settling_time_s": np.inf}))
    assert record["settling_time_s_high"] is None
    assert len(record) == 4 + 3 * len(METRICS) + 2
    assert record["task_id"] == "step+virgin"
    assert all(v is None or isinstance(v, str) or np.isfinite(v) for v in record.values())


def test_a_controller_once_a_period_without_another_problem_stands_by_what_it_tolerates():
    class Own:
        """An MPC of somebody's own: `init` and `step`, and nothing else."""

        def __init__(self, inner):
            self.problem, self.init, self.step = inner.problem, inner.init, inner.step
            self.low, self.high, self.gain = 0.0, 4.0, 49.4

    w = WRISTS["deviation"]
    found = compare(
        {"deviation": w}, {"deviation": GAINS["deviation"]}, designs={},
        periodic={"deviation": {"own": Own(linear_mpc(Problem_of_MPC(w)))}},
    )  # fmt: skip
    (s,) = (s for s in found.standings if s.controller == "own")
    assert np.isnan([s.Ms, s.delay_margin_s]).all()
    assert s.tolerated_delay_s == tolerated(w, linear_mpc(Problem_of_MPC(w))).delay_s > 0.0
    assert "delay_margin_s" in s.breaks
