"""The cascade: the PI with two degrees of freedom at Kc = 0, its law by hand, margins of python-control."""

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from design.controllers.cascade import CascadePI
from design.controllers.controller import sensors_of
from design.controllers.feedforward import FeedforwardPI
from design.controllers.lqi import LQI
from design.controllers.pi import PI
from design.controllers.pi_two_dof import TwoDofPI
from design.evaluation.cases import Case, stack
from design.evaluation.runner import play
from design.evaluation.steps import run
from design.evaluation.tasks import Task
from design.input_loop import command_margins, worst_pole
from design.margins import branch_responses, margins
from plants import Wrist
from plants.simulation.sensor import Measured
from tests.oracles.plain_loop import DT, Plant

WRIST = Wrist.flexion()


def test_without_an_inner_loop_it_is_the_pi_with_two_degrees_of_freedom():
    one = run(WRIST, TwoDofPI(3.0, 8.0, b=0.7), 15.0, WRIST.rest("virgin"), duration=3.0, record=True)[2]
    other = run(WRIST, CascadePI(3.0, 8.0, b=0.7), 15.0, WRIST.rest("virgin"), duration=3.0, record=True)[2]
    assert np.abs(one.angle - other.angle).max() < 1e-9


def by_hand(Kp, Ki, b, Kc, references, hold):
    p = {**WRIST.values, "rest_pressure": WRIST.hysteresis.rest_pressure}
    plant = Plant(p)
    integral, angles = plant.P - p["rest_pressure"], []
    for r in references:
        for _ in range(round(hold / DT)):
            wanted_pressure = p["rest_pressure"] + Kp * (b * r - plant.y) + integral
            wanted = (wanted_pressure + Kc * (wanted_pressure - plant.P)) / p["gain"]
            v = min(max(wanted, 0.0), 4.0)
            if not (wanted - v) * (r - plant.y) > 0.0:
                integral += Ki * (r - plant.y) * DT
            angles.append(plant.y)
            plant.move(v)
    return np.array(angles)


@pytest.mark.parametrize(("b", "Kc"), [(0.6, 1.0), (1.0, 4.0)])
def test_it_is_the_law_in_plain_python(b, Kc):
    asked = stack([Case(Task("virgin", 0.0, (15.0, -5.0), (2.0, 2.0)), WRIST)])
    played = play(asked, CascadePI(3.0, 8.0, b=b, Kc=Kc), record=True).trajectory
    assert np.abs(played.angle[:-1, 0] - by_hand(3.0, 8.0, b, Kc, (15.0, -5.0), 2.0)).max() < 1e-9


def test_it_holds_a_rest_at_any_angle():
    for start, angle in (("line1", 12.0), ("line2", -7.0)):
        state = WRIST.rest(start, angle)
        went = run(WRIST, CascadePI(3.0, 8.0, 1.6, 3.0), angle, state, duration=1.0, record=True)[2]
        assert np.abs(went.angle - angle).max() < 1e-6


def test_the_pressure_follows_faster_by_1_and_the_inner_gain():
    """Of a regulator with one rate, an inner loop alone is a first-order lag at (1 + Kc) times its rate."""
    k, dt, Kc = 2.0, 1e-3, 4.0
    c = CascadePI(0.0, 0.0, Kc=Kc).sampled(dt)
    state, p, went = CascadePI(0.0, 0.0, Kc=Kc).holding(130.0, Measured(0.0, 0.0, 100.0)), 100.0, []
    target = c.rest_pressure + float(state.integral)
    for _ in range(500):
        state, v = c.act(state, Measured(0.0, 0.0, p))
        p += -np.expm1(-k * dt) * (float(v) / c.volts_per_kPa - p)
        went.append(p)
    expected = target + (100.0 - target) * np.exp(-(1.0 + Kc) * k * dt * np.arange(1, 501))
    assert np.abs(np.array(went) - expected).max() < 0.06


@pytest.mark.slow
@pytest.mark.parametrize("gains", [(2.6, 8.8, 0.8, 1.0), (4.0, 9.0, 1.0, 0.2), (1.5, 3.0, 1.0, 6.0)])
def test_margins_are_those_of_python_control_and_of_the_law_linearised(gains):
    cascade = CascadePI(*gains)
    branches = branch_responses(WRIST, 3000)
    found = margins(branches, cascade)
    Kp, Ki, _, Kc = gains
    omega = np.geomspace(0.05, 3000.0, 5000)
    outer = control.tf([Kp, Ki * 1e-3 - Kp], [1.0, -1.0], 1e-3)
    peak, delay = 0.0, np.inf
    for b in branches:
        plant = control.ss(b.a, b.b[:, None], np.eye(2), 0.0, 1e-3)
        P, y = (control.ss2tf(plant[i, 0]) for i in (0, 1))
        z = np.exp(1j * omega * 1e-3)
        loop = ((1.0 + Kc) * outer(z) * y(z) + Kc * P(z)) / cascade.gain
        peak = max(peak, 1.0 / np.abs(1.0 + loop).min())
        crossed = control.FRD(loop, omega, dt=1e-3, smooth=True)
        _, pm, _, _, wc, _ = control.stability_margins(crossed, returnall=True)
        delay = min([delay, *np.mod(np.radians(pm), 2 * np.pi) / wc])
    assert float(found.Ms) == pytest.approx(peak, rel=2e-3)
    assert float(found.delay_margin_s) == pytest.approx(delay, rel=2e-3)
    assert command_margins(WRIST, cascade) == pytest.approx((peak, delay), rel=5e-3)
    assert worst_pole(WRIST, cascade)[0] < 1.0


def test_a_loop_is_called_unstable_where_a_pole_lies_outside_the_unit_circle():
    branches = branch_responses(WRIST)
    pairs = [(Kp, Kc) for Kp in (2.0, 400.0, 4000.0) for Kc in (0.0, 3.0)]
    many = CascadePI(*np.array([(Kp, 5.0, 1.0, Kc) for Kp, Kc in pairs]).T)
    found = margins(branches, many)
    poles = [worst_pole(WRIST, CascadePI(Kp, 5.0, 1.0, Kc))[0] for Kp, Kc in pairs]
    assert [np.isfinite(m) for m in found.Ms] == [p < 1.0 for p in poles]
    assert 0 < sum(p < 1.0 for p in poles) < len(pairs)


gains = st.floats(0.0, 50.0)


@given(gains, gains, st.floats(0.0, 20.0), st.floats(-1e6, 1e6), st.floats(-60.0, 60.0))
def test_the_command_stays_in_its_range(Kp, Ki, Kc, pressure, angle):
    c = CascadePI(Kp, Ki, Kc=Kc)
    state = c.holding(120.0, Measured(0.0, 0.0, 118.0))
    for _ in range(3):
        state, command = c.sampled().act(state, Measured(15.0 - angle, angle, pressure))
        assert c.low <= float(command) <= c.high


CONTROLLERS = [
    PI.of(WRIST, 3.0, 8.0), TwoDofPI.of(WRIST, 3.0, 8.0, 0.7), CascadePI.of(WRIST, 3.0, 8.0, Kc=1.0),
    LQI.of(WRIST, 600.0, -640.0, -70.0, 8.0, 45.0), FeedforwardPI.of(WRIST, Kp=1.2, Ki=2.2),
]  # fmt: skip


@pytest.mark.parametrize("controller", CONTROLLERS, ids=lambda c: type(c).__name__)
def test_a_controller_says_what_it_measures(controller):
    """Two courses of the pressure give the same commands where, and only where, it is not measured."""
    commands = []
    for size in (0.0, 20.0):
        c, state = controller.sampled(), controller.holding(120.0, Measured(0.0, 2.0, 120.0))
        for k in range(200):
            reference, angle = 5.0 if k < 100 else 7.0, 2.0 + 0.01 * k
            seen = Measured(reference - angle, angle, 120.0 + size * np.sin(0.1 * k))
            state, command = c.act(state, seen)
        commands.append(float(command))
    assert (commands[0] != commands[1]) == ("pressure" in sensors_of(controller))


@pytest.mark.parametrize("bad", [{"Kc": -1.0}, {"b": np.nan}, {"Kp": np.inf}])
def test_settings_that_make_no_sense_are_refused(bad):
    with pytest.raises(ValueError, match=f"{next(iter(bad))} must be finite"):
        CascadePI(**{"Kp": 1.0, "Ki": 1.0, **bad})
