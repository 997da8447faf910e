"""Margins on the branches are closed forms where there are such, and python-control's elsewhere."""

from functools import cache

import control
import numpy as np
import pytest

from design.controllers.pi import PI
from design.open_loops import OpenLoopTransfer, _row, loop_tf, open_loops
from design.robustness.predictions.margins import branch_margins, statements, steepest_rate
from design.status import Status
from design.synthesis.requirements import Limits
from plants import Wrist
from plants.effects import DeadTime
from plants.linearisation import RATES, branch_slopes
from reports.robustness.claims import claim_words

BRANCHES = tuple(branch_slopes(Wrist.flexion()))

WRIST = Wrist.flexion()
GAINS = [(1.2, 2.2), (3.13, 10.4), (9.0, 60.0)]
OMEGA = np.geomspace(1e-2, 0.999 * np.pi / 1e-3, 1500)


@cache
def rows_of(gains):
    return branch_margins(WRIST, PI(*gains))


@pytest.mark.parametrize(("k", "dead_time"), [(2.0, 0.0), (5.0, 0.1), (5.0, 0.25)])
def test_an_integrator_behind_a_dead_time_has_the_margins_of_the_formula(k, dead_time):
    # L = k exp(-j w d) / (j w): crosses one at w = k with a phase of -90 degrees - k d, and -180 degrees at
    # w = pi / (2 d) with a gain of 2 k d / pi.
    row = _row(OpenLoopTransfer("a", "b", lambda w: k * np.exp(-1j * w * dead_time) / (1j * w)), OMEGA, True)
    assert row["stable"]
    assert row["phase_margin_deg"] == pytest.approx(90.0 - np.degrees(k * dead_time), abs=0.01)
    assert row["delay_margin_s"] == pytest.approx(np.pi / 2.0 / k - dead_time, rel=1e-4)
    if dead_time:
        assert row["gain_margin"] == pytest.approx(np.pi / (2.0 * k * dead_time), rel=1e-4)
        return
    # Without it S = s / (s + k), T = k / (s + k), and (S - T) has the magnitude 1 everywhere.
    assert (row["Ms"], row["Mt"]) == pytest.approx((1.0, 1.0), abs=1e-4)
    assert row["disk_margin"] == pytest.approx(2.0)


@pytest.mark.parametrize("zeta", [0.05, 0.2, 0.5])
def test_a_loop_of_second_order_has_the_peaks_of_the_textbook(zeta):
    # L = 1 / (s (s + 2 zeta)): T = 1 / (s^2 + 2 zeta s + 1) peaks at 1 / (2 zeta sqrt(1 - zeta^2)); S - T has
    # |.|^2 = ((1 + x)^2 + 4 zeta^2 x) / ((1 - x)^2 + 4 zeta^2 x), x = w^2, whose peak is at x = 1.
    row = _row(OpenLoopTransfer("a", "b", lambda w: 1.0 / (1j * w * (1j * w + 2.0 * zeta))), OMEGA, True)
    assert row["Mt"] == pytest.approx(1.0 / (2.0 * zeta * np.sqrt(1.0 - zeta**2)), rel=1e-6)
    assert row["disk_margin"] == pytest.approx(2.0 * zeta / np.sqrt(1.0 + zeta**2), rel=1e-6)


@pytest.mark.parametrize("dead_time", [0.0, 0.1])
def test_margins_read_piece_by_piece_are_those_of_the_whole_response(dead_time):
    (loop,) = open_loops(WRIST, PI(3.13, 10.4), dead_time, ("fast",))[1:2]
    whole = control.frequency_response(loop_tf(WRIST, PI(3.13, 10.4), loop.branch, loop.rate), OMEGA).complex
    whole = np.ravel(whole) * np.exp(-1j * OMEGA * dead_time)
    np.testing.assert_allclose(loop.at(OMEGA), whole, rtol=1e-12)
    gm, pm, *_ = control.stability_margins(control.frd(whole, OMEGA, smooth=True), returnall=True)
    assert len(gm) > 10 * dead_time  # many crossings behind a dead time
    row = _row(loop, OMEGA, True)
    assert row["gain_margin"] == pytest.approx(min(gm[gm > 1.0]), rel=1e-9)
    assert row["phase_margin_deg"] == pytest.approx(min(pm), rel=1e-9)


def peak(system, low=0.1, high=100.0):
    """Largest magnitude of a python-control system, by two grids, the second within the first."""
    for _ in range(2):
        omega = np.geomspace(low, high, 300)
        size = np.abs(np.ravel(control.frequency_response(system, omega).complex))
        at = int(np.clip(size.argmax(), 1, len(omega) - 2))
        low, high = omega[at - 1], omega[at + 1]
    return float(size.max()), omega


@pytest.mark.parametrize("gains", GAINS)
@pytest.mark.parametrize("place", [("line1", "slow"), ("transit", "slow"), ("line2", "fast")])
def test_peaks_and_disk_margin_are_those_of_python_controls_closed_loops(gains, place):
    row = next(r for r in rows_of(gains) if (r["branch"], r["rate"]) == place)
    loop = loop_tf(WRIST, PI(*gains), *place)
    S, T = control.feedback(1, loop), control.feedback(loop, 1)
    assert row["Ms"] == pytest.approx(peak(S)[0], rel=1e-5)
    assert row["Mt"] == pytest.approx(max(1.0, peak(T)[0]), rel=1e-5)  # T is 1 at zero frequency
    _, omega = peak(S - T)
    disk, _, _ = control.disk_margins(loop, omega, skew=0.0)
    assert row["disk_margin"] == pytest.approx(float(disk), rel=1e-5)


def test_the_grid_alone_would_read_a_sharp_peak_too_low():
    loop = loop_tf(WRIST, PI(9.0, 60.0), "line1", "slow")
    on_grid = 1.0 / np.abs(1.0 + np.ravel(control.frequency_response(loop, OMEGA).complex)).min()
    row = next(r for r in rows_of((9.0, 60.0)) if (r["branch"], r["rate"]) == ("line1", "slow"))
    exact, _ = peak(control.feedback(1, loop))
    assert exact > 7.0
    assert exact / on_grid - 1.0 > 1e-3
    assert row["Ms"] == pytest.approx(exact, rel=1e-6)


def test_the_steepest_rate_is_the_largest_slope_of_the_law_by_differences():
    p = WRIST.regulator
    e = np.linspace(0.0, 10.0 * p.e0, 200_001)
    flow = (p.k_slow + (p.k_fast - p.k_slow) * e**2 / (e**2 + p.e0**2)) * e
    slope = np.diff(flow) / np.diff(e)
    assert steepest_rate(WRIST) == pytest.approx(slope.max(), rel=1e-6)
    assert e[np.argmax(slope)] == pytest.approx(np.sqrt(3.0) * p.e0, rel=1e-2)
    assert steepest_rate(WRIST) - p.k_fast == pytest.approx((p.k_fast - p.k_slow) / 8.0)


def test_rows_of_the_steepest_rate_follow_and_are_no_better_at_high_gain():
    rows = branch_margins(WRIST, PI(20.0, 40.0), 0.05)
    assert [(r["branch"], r["rate"]) for r in rows[6:]] == [(b, "steepest") for b in BRANCHES]
    of = {(r["branch"], r["rate"]): r for r in rows}
    assert of["line1", "steepest"]["gain_margin"] < of["line1", "fast"]["gain_margin"]
    one_rate = WRIST.with_values(k_slow=5.0, k_fast=5.0)
    assert {r["rate"] for r in branch_margins(one_rate, PI(1.0, 2.0))} == set(RATES)


@pytest.mark.slow
@pytest.mark.parametrize("gains", [(3.13, 10.4)])
def test_dead_time_beside_the_loop_is_dead_time_in_the_tube(gains):
    beside = branch_margins(WRIST, PI(*gains), 0.1)
    inside = branch_margins(WRIST + DeadTime(0.06), PI(*gains), 0.04)
    for a, b in zip(beside, inside, strict=True):
        assert a["stable"] == b["stable"]
        for key in ("Ms", "Mt", "disk_margin", "delay_margin_s", "phase_margin_deg"):
            assert a[key] == pytest.approx(b[key], rel=1e-6), key


def test_an_unstable_branch_has_no_margins_and_breaks_the_statement():
    rows = branch_margins(WRIST, PI(0.5, 300.0))
    bad = next(r for r in rows if not r["stable"])
    assert (bad["Ms"], bad["Mt"], bad["disk_margin"], bad["delay_margin_s"]) == (np.inf, np.inf, 0.0, 0.0)
    said = statements(rows, Limits())
    assert said[0].holds is False
    assert [s.value for s in said if claim_words(s.claim).startswith(("gain", "phase", "disk"))] == [
        0.0,
        0.0,
        0.0,
    ]
    assert all(s.holds is False for s in said if " at " in claim_words(s.claim))


def test_statements_hold_the_worst_row_against_its_limit():
    rows = rows_of((9.0, 60.0))
    said = {claim_words(s.claim): s for s in statements(rows, Limits(Ms=2.0, delay_margin_s=0.02))}
    Ms = said["Ms at most 2 on every branch"]
    assert (Ms.holds, Ms.branch) == (False, "line1, slow regulator rate")
    assert Ms.value == max(r["Ms"] for r in rows)
    delay = said["delay margin at least 20 ms on every branch"]
    assert delay.holds is True
    assert delay.value == min(r["delay_margin_s"] for r in rows)
    Mt = said["Mt at most 2 on every branch"]
    assert (Mt.holds, Mt.value) == (max(r["Mt"] for r in rows) <= 2.0, max(r["Mt"] for r in rows))
    assert {s.status for s in said.values()} == {Status.PREDICTED}


def test_a_limit_that_is_none_is_told_and_not_judged():
    said = statements(rows_of((9.0, 60.0)), Limits(Ms=None, Mt=None, delay_margin_s=None))
    assert [s.holds for s in said[1:]] == [None] * 6
    assert said[1].value == pytest.approx(7.7428, abs=1e-3)
