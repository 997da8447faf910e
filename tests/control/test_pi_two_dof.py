"""The PI with two degrees of freedom: the paper's at weight 1, the standard form beside, the same margins."""

from math import exp

import control
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from design.controllers.measurement.plausible import SensorLimits
from design.controllers.pi import PI
from design.controllers.pi_two_dof import TwoDofPI
from design.evaluation.cases import Case, stack
from design.evaluation.runner import play
from design.evaluation.steps import run
from design.evaluation.tasks import Task
from design.export.parts_of import of_controller
from design.margins import branch_responses, margins
from design.robustness.certificates.continuous.virgin import time_on_virgin_curve
from design.robustness.predictions.harmonic_balance import loop_gain
from design.robustness.predictions.limit_cycles import limit_cycles
from design.robustness.predictions.orbits import large_swings
from plants import Wrist
from plants.linearisation import branch_ss
from plants.simulation.sensor import Measured
from tests.oracles.plain_loop import DT, Plant

WRIST = Wrist.flexion()


@pytest.mark.parametrize("start", ["virgin", "line1", "inside"])
def test_with_weight_1_and_no_filter_it_is_the_papers_pi(start):
    one = run(WRIST, PI(3.0, 8.0), 15.0, WRIST.rest(start), duration=3.0, record=True)[2]
    other = run(WRIST, TwoDofPI(3.0, 8.0), 15.0, WRIST.rest(start), duration=3.0, record=True)[2]
    assert np.abs(one.angle - other.angle).max() < 1e-9


def by_hand(Kp, Ki, b, Tf, references, hold):
    """The loop in plain Python, the standard form written out; references one after the other."""
    p = {**WRIST.values, "rest_pressure": WRIST.hysteresis.rest_pressure}
    plant, keep = Plant(p), exp(-DT / Tf) if Tf else 0.0
    integral, yf, angles = plant.P - p["rest_pressure"], 0.0, []
    for r in references:
        for _ in range(round(hold / DT)):
            yf = keep * yf + (1.0 - keep) * plant.y
            wanted = (p["rest_pressure"] + Kp * (b * r - yf) + integral) / p["gain"]
            v = min(max(wanted, 0.0), 4.0)
            if not (wanted - v) * (r - yf) > 0.0:
                integral += Ki * (r - yf) * DT
            angles.append(plant.y)
            plant.move(v)
    return np.array(angles)


@pytest.mark.parametrize(("b", "Tf"), [(0.6, 0.0), (1.7, 0.0), (1.0, 0.02), (0.8, 0.01)])
def test_it_is_the_standard_form_in_plain_python(b, Tf):
    controller = TwoDofPI(3.0, 8.0, b=b, Tf=Tf)
    asked = stack([Case(Task("virgin", 0.0, (15.0, -5.0), (2.0, 2.0)), WRIST)])
    played = play(asked, controller, record=True).trajectory
    assert np.abs(played.angle[:-1, 0] - by_hand(3.0, 8.0, b, Tf, (15.0, -5.0), 2.0)).max() < 1e-9


def test_it_holds_a_rest_at_any_angle_with_any_weight():
    for start, angle in (("line1", 12.0), ("line2", -7.0)):
        state = WRIST.rest(start, angle)
        _, _, went = run(WRIST, TwoDofPI(3.0, 8.0, b=1.6, Tf=0.01), angle, state, duration=1.0, record=True)
        assert np.abs(went.angle - angle).max() < 1e-6


def test_the_weight_changes_no_margin_and_the_filter_does_as_python_control_says():
    branches = branch_responses(WRIST)
    plain, weighted = (margins(branches, c) for c in (PI(4.0, 9.0), TwoDofPI(4.0, 9.0, b=0.6)))
    assert float(weighted.Ms) == float(plain.Ms)
    keep = exp(-1e-3 / 0.05)
    filtered = control.tf([1.0 - keep, 0.0], [1.0, -keep], 1e-3)
    law = control.tf([4.0, 9.0e-3 - 4.0], [1.0, -1.0], 1e-3) / PI(4.0, 9.0).gain
    omega = np.geomspace(0.05, 500.0, 5000)
    z = np.exp(1j * omega * 1e-3)
    peak = 0.0
    for b in branches:
        loop = law(z) * filtered(z) * branch_ss(WRIST, b.branch, b.rate)(z)
        peak = max(peak, 1.0 / np.abs(1.0 + loop).min())
    found = margins(branches, TwoDofPI(4.0, 9.0, Tf=0.05))
    assert float(found.Ms) == pytest.approx(peak, rel=1e-3)
    assert float(found.Ms) > float(plain.Ms)


def test_a_filtered_loop_swings_as_predicted_and_as_the_plain_loop_does():
    hunting = TwoDofPI(1.0, 40.0, b=0.7, Tf=0.02)
    (repels,) = limit_cycles(WRIST, hunting)
    keep = exp(-1e-3 / 0.02)
    z = np.exp(1j * repels.frequency_rad_s * 1e-3)
    law = (1.0 + 40.0e-3 / (z - 1.0)) * (1.0 - keep) * z / (z - keep) / hunting.gain
    plain = (1.0 + 40.0e-3 / (z - 1.0)) / hunting.gain
    balance = loop_gain(WRIST, PI(1.0, 40.0), repels.amplitude_kPa, repels.frequency_rad_s)[0, 0]
    assert abs(1.0 + balance * law / plain) < 1e-6
    assert repels.confirmed
    swings = large_swings(WRIST, hunting)
    went = by_hand(1.0, 40.0, 0.7, 0.02, (30.0, 0.0), 30.0)[-10_000:]
    assert swings.persisting == swings.lanes
    assert swings.amplitude_deg == pytest.approx(0.5 * np.ptp(went), rel=1e-3)


@pytest.mark.parametrize("b", [0.6, 1.8])
def test_a_weighted_step_leaves_the_virgin_curve_within_its_bounds(b):
    weighted = TwoDofPI(3.0, 8.0, b=b, Tf=0.01)
    bounds = time_on_virgin_curve(WRIST, weighted, 15.0)
    p = WRIST.hysteresis
    most = weighted.high * weighted.gain - p.rest_pressure
    command = lambda t: min((b * 3.0 + 8.0 * t) * 15.0, most)  # noqa: E731
    for rate, expected in (
        (WRIST.regulator.k_fast, bounds.earliest),
        (WRIST.regulator.k_slow, bounds.latest),
    ):
        solved = solve_ivp(
            lambda t, x, k=rate: k * (command(t) - x), (0.0, 3.0), [0.0], rtol=1e-9, atol=1e-9,
            max_step=0.01, events=lambda t, x: x[0] - p.w1 / p.a1,
        )  # fmt: skip
        assert float(solved.t_events[0][0]) == pytest.approx(expected, rel=1e-5)


def test_it_becomes_c():
    sensors = SensorLimits.of(Wrist.flexion())
    part = of_controller(
        "two_dof", "a PI with two degrees of freedom", TwoDofPI(3.0, 8.0, b=0.7), sensors, 1e-3
    )
    assert part.settings["b"] == 0.7
    assert {m.member for m in part.members} >= {"integral_kPa", "angle_deg"}


@pytest.mark.parametrize("bad", [{"b": -0.1}, {"Tf": float("nan")}, {"b": float("inf")}])
def test_settings_that_make_no_sense_are_refused(bad):
    with pytest.raises(ValueError, match="b and Tf"):
        TwoDofPI(1.0, 1.0, **bad)


@pytest.mark.parametrize("gains", [(np.inf, 1.0), (1.0, np.inf), (np.nan, 1.0), (1.0, -1e-9)])
def test_gains_of_a_pi_are_finite_and_not_negative(gains):
    with pytest.raises(ValueError, match="finite and not negative"):
        PI(*gains)


def test_the_command_of_a_state_holds_the_pressure_that_it_was_taken_over_at():
    c = TwoDofPI(3.0, 8.0, b=0.6)
    for pressure, angle in ((130.0, 10.0), (70.0, -8.0), (100.0, 0.0)):
        held = c.holding(pressure, Measured(0.0, angle, pressure))
        assert float(c.command(held)) * c.gain == pytest.approx(pressure, abs=1e-9)


@pytest.mark.parametrize(("error", "moves"), [(0.1, False), (-0.1, True)])
def test_the_integral_stands_still_however_little_the_command_is_clipped(error, moves):
    c = TwoDofPI(3.0, 8.0)
    at = c.holding(4.0 * c.gain + 0.5 - 3.0 * error, Measured(0.0, 0.0, 100.0))  # 0.5 kPa above the range
    after, command = c.sampled().act(at, Measured(error, 0.0, 100.0))
    assert float(command) == 4.0
    assert (float(after.integral) != float(at.integral)) == moves
