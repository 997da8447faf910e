"""The comparison is complete, carries the doubt about the paper's gains, and ranks nothing within it."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from design.compare import (
    METRICS,
    PAPER,
    TUNED,
    Comparison,
    Row,
    Standing,
    compare,
    on_tasks,
    row_record,
    task_scenarios,
    together,
    verdicts,
)
from design.loop import run
from design.metrics import Metrics
from design.pi import PI
from design.requirements import Limits
from design.rules import baselines, paper_range
from plants import Wrist

WRISTS = {"flexion": Wrist.flexion(), "deviation": Wrist.deviation()}
GAINS = {"flexion": PI(3.0, 9.0), "deviation": PI(6.0, 18.0)}
NAMES = {TUNED, PAPER, "SIMC", "AMIGO", "Ziegler-Nichols"}


@cache
def both() -> Comparison:
    return compare(WRISTS, GAINS)


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
    assert len(comparison.verdicts) == 2


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
    for name, pi in {**baselines(w), TUNED: GAINS[motion]}.items():
        for s in task_scenarios(w)[::3]:
            judged, _, _ = run(w, pi, s.reference, w.rest(s.start, s.angle))
            found = row(comparison, motion, f"0 to {s.reference:+g} deg, {s.start}", name)
            assert found.metrics == {n: float(getattr(judged, n)[0]) for n in METRICS}


def test_a_return_starts_from_where_five_seconds_of_holding_have_led():
    w, pi = WRISTS["flexion"], PI(1.2, 2.2)
    (found,) = on_tasks(w, [pi])["return from -15 to 0 deg"]
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
    found = compare({"flexion": WRISTS["flexion"]}, {"flexion": GAINS["flexion"]})
    assert {r.motion for r in found.rows} == {"flexion"}
    assert len(found.verdicts) == 1


def test_standings_tell_which_limits_are_broken(comparison):
    for s in comparison.standings:
        broken = {
            "overshoot_percent": s.worst_overshoot_percent > 5.0,
            "Ms": s.Ms > 2.0,
            "delay_margin_s": s.delay_margin_s < 0.060,
        }
        assert {n for n in s.breaks if n in broken} == {n for n, is_broken in broken.items() if is_broken}
    assert any(s.breaks for s in comparison.standings)


def test_without_limits_none_is_broken():
    none = Limits(None, None, None, None, None)
    found = compare({"flexion": WRISTS["flexion"]}, {"flexion": GAINS["flexion"]}, none)
    assert not any(s.breaks for s in found.standings)


def made_up(ours: float, low: float, high: float) -> str:
    """The verdict on a tuned PI that settles in `ours` against a paper's between `low` and `high`."""
    rows = [
        Row("flexion", "task", TUNED, *[{"settling_time_s": ours}] * 3),
        Row("flexion", "task", PAPER, {"settling_time_s": (low + high) / 2}, {"settling_time_s": low},
            {"settling_time_s": high}),
    ]  # fmt: skip
    standings = [Standing("flexion", name, 1.0, 1.0, 1.5, 0.1, 0.0, 1.0, 1.0, ()) for name in (TUNED, PAPER)]
    (said,) = verdicts(rows, standings)
    return said


@pytest.mark.parametrize("ours", [2.0, 3.0, 4.0])
def test_within_the_range_of_the_paper_nothing_is_ranked(ours):
    said = made_up(ours, 2.0, 4.0)
    assert "not to be ranked" in said
    assert "ahead" not in said
    assert "behind" not in said


def test_outside_of_the_range_the_order_is_said():
    assert "ahead of the paper's PI over the whole range" in made_up(1.99, 2.0, 4.0)
    assert "behind the paper's PI over the whole range" in made_up(4.01, 2.0, 4.0)


def test_what_never_settles_is_never_said_to_be_ahead():
    assert "not to be ranked" in made_up(np.inf, np.inf, np.inf)
    assert "behind" in made_up(np.inf, 2.0, 4.0)
    assert "more than 10 s" in made_up(np.inf, 2.0, 4.0)


def test_a_record_is_flat_and_has_no_infinity(comparison):
    r = row(comparison, "flexion", "0 to +15 deg, virgin", PAPER)
    record = row_record(replace(r, high={**r.high, "settling_time_s": np.inf}))
    assert record["settling_time_s_high"] is None
    assert len(record) == 3 + 3 * len(METRICS)
    assert all(v is None or isinstance(v, str) or np.isfinite(v) for v in record.values())
