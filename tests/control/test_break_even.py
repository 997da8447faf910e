"""The break-even map compares like with like, and its numbers are where the ratio crosses 1."""

import numpy as np
import pytest

from design.comparison.break_even import GRIDS, break_even, crossing
from design.controllers.controller import Measured
from design.controllers.feedforward import Feedforward, FeedforwardPI
from design.controllers.pi import PI
from design.evaluation.scenarios import corner
from design.evaluation.steps import run
from plants.effects.regulator.dead_time import DeadTime
from plants.errors import InputError
from plants.wrist import STARTS, Wrist
from reports.comparison.contest.break_even_figure import break_even_figure

WRIST, PLAIN = Wrist.flexion(), PI(3.13, 10.4)
SMALL = {
    "loop width": np.array([-0.5, -0.05, 0.0, 0.05, 0.5]),
    "slope": np.array([-0.1, 0.0, 0.1]),
    "starting memory": np.array([0.0, 0.5]),
    "dead time": np.array([0.0, 0.03]),
}


@pytest.fixture(scope="module")
def found():
    others = {"feedforward": Feedforward.of(WRIST), "PI": PLAIN}
    return break_even(WRIST, PLAIN, others, SMALL, duration=4.0)


def one_by_one(controller, wrist):
    """Worst settling time and mean IAE of the eight steps, each a run of its own."""
    judged = [
        run(wrist, controller, sign * 15.0, wrist.rest(start), duration=4.0)[0]
        for sign in (1, -1) for start in STARTS
    ]  # fmt: skip
    return max(float(m.settling_time_s[0]) for m in judged), np.mean([float(m.iae_deg_s[0]) for m in judged])


def test_a_controller_against_itself_is_at_one_everywhere(found):
    for kind in SMALL:
        curve = found.of(kind, "PI")
        for metric in ("settling", "IAE"):
            ratio = curve.ratio(metric)
            assert ratio == pytest.approx(np.ones(len(SMALL[kind])), abs=1e-12)
        assert curve.break_even("IAE")[1] is None


def test_the_curves_are_those_of_single_runs_on_the_true_wrist(found):
    curve = found.of("loop width", "feedforward")
    for error in (0.0, 0.05):
        true, n = corner(WRIST, 1.0 + error, 1.0, 1.0), int(np.flatnonzero(curve.errors == error)[0])
        assert (curve.plain_settling[n], curve.plain_iae[n]) == pytest.approx(
            one_by_one(PLAIN, true), abs=1e-9
        )
    late = found.of("dead time", "feedforward")
    truth = one_by_one(PLAIN, WRIST + DeadTime(0.03))
    assert (late.plain_settling[1], late.plain_iae[1]) == pytest.approx(truth, abs=1e-9)


def test_a_memory_that_is_off_is_half_the_height_of_the_loop_from_the_true_one(found):
    """By hand: lines of 0.36 deg/kPa, 6 deg off the origin, 12 deg from one to the other at any pressure."""
    controller, believed = Feedforward.of(WRIST), {"virgin": 3.0, "inside": 3.0, "line1": 6.0, "line2": -6.0}
    iae = []
    for start, sign in ((start, sign) for sign in (1, -1) for start in STARTS):
        rest = WRIST.rest(start)
        held = controller.holding(rest.pressure, Measured(0.0, believed[start], rest.pressure))
        judged, _, _ = run(WRIST, controller, sign * 15.0, rest, held, duration=4.0)
        iae.append(float(judged.iae_deg_s[0]))
    curve = found.of("starting memory", "feedforward")
    assert curve.iae[1] == pytest.approx(np.mean(iae), abs=1e-9)
    assert curve.iae[1] > 1.01 * curve.iae[0]


def test_a_feedforward_alone_stands_as_far_off_as_its_loop_is_too_narrow(found):
    """On the line 15 deg are held at a pressure that a loop wider by 3 deg takes to 12 deg."""
    curve = found.of("loop width", "feedforward")
    assert np.isinf(curve.settling[[0, -1]]).all()
    wide = corner(WRIST, 1.5, 1.0, 1.0)
    slow = Feedforward.of(WRIST, speed=5.0)  # less than 1 / Tw: nothing is overdriven, it arrives on line 1
    judged, _, _ = run(wide, slow, 15.0, duration=4.0)
    assert judged.steady_state_error_deg[0] == pytest.approx(3.0, abs=0.02)


def test_a_pi_keeps_a_feedforward_ahead_for_longer():
    grid = {"loop width": GRIDS["loop width"][[0, 8, 24, 34, 44, 60]]}
    others = {"alone": Feedforward.of(WRIST), "PI": FeedforwardPI.of(WRIST, Kp=8.0, Ki=20.0)}
    found = break_even(WRIST, PLAIN, others, grid, duration=5.0)
    alone, helped = (found.of("loop width", n).break_even("IAE")[1] for n in ("alone", "PI"))
    assert alone is not None
    assert helped is None or helped > alone


def test_crossings_lie_where_the_ratio_is_one():
    errors = np.array([0.0, 0.1, 0.2, 0.3])
    assert crossing(errors, np.array([0.2, 0.6, 1.4, 0.9])) == pytest.approx(0.15)
    assert crossing(-errors, np.array([0.2, 0.6, 1.4, 0.9])) == pytest.approx(-0.15)
    assert crossing(errors, np.array([0.2, 0.6, np.inf, np.inf])) == pytest.approx(0.1)
    assert crossing(errors, np.array([0.2, 0.6, 0.7, 1.0])) is None
    assert crossing(errors, np.array([1.2, 0.6, 0.7, 1.0])) == 0.0
    assert crossing(errors, np.array([0.2, np.nan, 2.0, 2.0])) is None


def test_the_rows_are_the_numbers_of_the_curves(found):
    rows = found.rows()
    assert len(rows) == len(SMALL) * 2 * 2
    for row in rows:
        curve = found.of(row["kind"], row["controller"])
        assert (row["break_even_low"], row["break_even_high"]) == curve.break_even(row["metric"])
        assert row["tried_low"] == SMALL[row["kind"]][0]


def test_steps_that_no_command_can_hold_are_left_out():
    flat = break_even(WRIST, PLAIN, {"PI": PLAIN}, {"slope": np.array([-0.6, 0.0])}, duration=1.0)
    assert np.isnan(flat.of("slope", "PI").settling[0])


def test_bad_input_is_refused():
    def asked(wrist, grids):
        with pytest.raises(InputError) as caught:
            break_even(wrist, PLAIN, {}, grids)
        return str(caught.value)

    assert "dead-time" in asked(WRIST + DeadTime(0.01), None)
    assert "one of loop width, slope" in asked(WRIST, {"colour": np.array([0.0, 1.0])})
    assert "have 0 among them" in asked(WRIST, {"slope": np.array([0.1, 0.2])})


def test_the_figure_draws_every_curve_and_marks_every_break_even(found):
    axes = break_even_figure(found).axes
    assert len(axes) == 2 * len(SMALL)
    curve, panel = found.of("loop width", "feedforward"), axes[0]
    drawn = next(line for line in panel.lines if line.get_label() == "feedforward")
    assert drawn.get_xdata() == pytest.approx(100.0 * curve.errors)
    assert drawn.get_ydata()[2] == pytest.approx(curve.ratio("settling")[2])
    assert np.isnan(drawn.get_ydata()[0])  # does not settle: an arrow at the edge instead
    arrows = [line for line in panel.lines if line.get_marker() == "^" and line.get_xdata().size]
    assert arrows[0].get_xdata()[0] == pytest.approx(100.0 * curve.errors[0])
    assert panel.get_ylim()[1] / 1.5 < arrows[0].get_ydata()[0] < panel.get_ylim()[1]
    marks = sorted(line.get_xdata()[0] for line in panel.lines if line.get_marker() == "o")
    assert marks == pytest.approx([100.0 * e for e in curve.break_even("settling")])
