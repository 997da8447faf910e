"""Margins of an MPC at rest: the method on a PI whose margins python-control tells, and the dead time at
which the loop of an MPC becomes unstable."""

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import control
import numpy as np
import pytest

from design.controllers.pi import PI
from design.mpc.formulations.linear import linear_mpc
from design.mpc.margins_at_rest import PERIODS, PULSE, _margins, margins_at_rest, pulse_response, straight
from design.mpc.problem import nominal
from plants import Wrist
from plants.effects.regulator.dead_time import DeadTime
from plants.linearisation import branch_matrices, branch_slopes
from plants.parameters.remainder import UncertaintyWeight
from plants.simulation.sensor import Measured

WRIST = Wrist.flexion()
PERIOD = 0.02


@dataclass(frozen=True)
class PeriodicPI:
    """A PI once a period, as an MPC is in the loop."""

    problem: Any

    @classmethod
    def made(cls, wrist):
        return cls(SimpleNamespace(wrist=wrist, period=PERIOD, substeps=20, low=0.0, high=4.0))

    @property
    def law(self):
        return PI.of(WRIST, 1.5, 5.0)

    def init(self, seen):
        return self.law.holding(seen.pressure)

    def step(self, state, seen):
        after, command = self.law.sampled(PERIOD).act(state, seen)
        return after, float(command), None


def sensitivity_of_python_control(branch, rate, late=0):
    """Of the loop of the PI and the plant held for a period, whose commands arrive so many periods late."""
    a, b = branch_matrices(WRIST, branch, rate)
    held = np.linalg.matrix_power(a, 20), sum(np.linalg.matrix_power(a, i) @ b for i in range(20))
    plant = control.ss(*held, [[0.0, 1.0]], 0.0, PERIOD)
    law = control.tf([1.5, 5.0 * PERIOD - 1.5], [1.0, -1.0], PERIOD) / WRIST.regulator.gain
    waits = control.tf([1.0], [1.0] + [0.0] * late, PERIOD)
    return control.feedback(1, control.ss(law) * plant * control.ss(waits)), law * control.tf(plant) * waits


@pytest.mark.parametrize("late", [0, 2])
@pytest.mark.parametrize(("branch", "rate"), [("line1", "fast"), ("transit", "slow")])
def test_the_pulse_response_is_that_of_the_sensitivity_of_python_control(branch, rate, late):
    a, b = branch_matrices(WRIST, branch, rate)
    pi = PeriodicPI.made(straight(WRIST, branch_slopes(WRIST)[branch], rate))
    found = np.array(list(pulse_response(pi, a, b, 20 * late) if late else pulse_response(pi, a, b)))
    pulse = np.eye(found.size)[0]
    expected, _ = sensitivity_of_python_control(branch, rate, late)
    told = control.forced_response(expected, np.arange(found.size) * PERIOD, pulse).outputs
    np.testing.assert_allclose(pulse + found, told, atol=1e-6)


@pytest.mark.parametrize(("branch", "rate"), [("line1", "fast"), ("transit", "slow")])
def test_margins_are_those_of_python_control(branch, rate):
    a, b = branch_matrices(WRIST, branch, rate)
    pi = PeriodicPI.made(straight(WRIST, branch_slopes(WRIST)[branch], rate))
    told = _margins(np.array(list(pulse_response(pi, a, b))), PERIOD)
    sensitivity, loop = sensitivity_of_python_control(branch, rate)
    omega = np.geomspace(0.01, 0.999 * np.pi / PERIOD, 5000)
    size = np.abs(sensitivity(np.exp(1j * omega * PERIOD)))
    complementary = np.abs(1.0 - sensitivity(np.exp(1j * omega * PERIOD)))
    assert told.Ms == pytest.approx(size.max(), rel=2e-3)
    assert told.Mt == pytest.approx(complementary.max(), rel=2e-3)
    sampled = control.frd(loop(np.exp(1j * omega * PERIOD)), omega, smooth=True)
    _, phase, _, crossing = control.margin(sampled)
    assert told.delay_margin_s == pytest.approx(np.deg2rad(phase) / crossing, rel=1e-2)


@pytest.mark.slow
def test_a_loop_is_unstable_beyond_its_delay_margin_and_stable_below():
    mpc = linear_mpc(nominal(WRIST))
    told = margins_at_rest(mpc, [WRIST])
    assert 1.0 < told.Ms < 3.0
    sizes = []
    for share in (0.8, 1.3):
        largest = 0.0
        for branch in ("line1", "transit"):
            for rate in ("fast", "slow"):
                own = mpc.on(replace(mpc.problem, wrist=straight(WRIST, branch_slopes(WRIST)[branch], rate)))
                late = round(share * told.delay_margin_s / 1e-3)
                went = np.abs(list(pulse_response(own, *branch_matrices(WRIST, branch, rate), late)))
                largest = max(largest, went[-PERIODS:].max())
        sizes.append(largest)
    assert sizes[0] < 1e-2
    assert sizes[1] > 0.1


def test_a_dead_time_of_the_plant_is_in_its_margins():
    mpc = linear_mpc(nominal(WRIST))
    plain, late = (margins_at_rest(mpc, [w]) for w in (WRIST, WRIST + DeadTime(0.005)))
    share_of_a_period = 3e-3
    assert late.delay_margin_s == pytest.approx(plain.delay_margin_s - 0.005, abs=share_of_a_period)
    assert margins_at_rest(mpc, [WRIST], (0.005,)) == late
    assert late.Ms > plain.Ms


def test_unmodelled_dynamics_of_one_gain_at_all_frequencies_count_as_that_share_of_mt():
    mpc = linear_mpc(nominal(WRIST))
    told = margins_at_rest(mpc, [WRIST], weight=UncertaintyWeight(0.3, 0.3, 1.0, 1.0))
    assert pytest.approx(0.3 * told.Mt, rel=1e-3) == told.WT
    assert replace(told, WT=None) == margins_at_rest(mpc, [WRIST])


@pytest.mark.slow
def test_the_margins_of_a_loop_that_does_not_come_to_rest_are_none():
    mpc = linear_mpc(nominal(WRIST))
    told = margins_at_rest(mpc, [WRIST], (0.05,))
    assert (told.Ms, told.Mt, told.delay_margin_s) == (np.inf, np.inf, 0.0)


def test_a_pulse_is_small_and_the_start_at_rest():
    model = straight(WRIST, 0.08, "slow")
    mpc = linear_mpc(nominal(model))
    state = mpc.init(Measured(0.0, 0.08 * (118.56 - 100.0), 118.56))
    assert state.command == pytest.approx(118.56 / 49.4)
    assert PULSE * WRIST.regulator.gain < 0.1


def test_the_wrist_is_held_well_inside_a_range_that_does_not_begin_at_zero():
    a, b = branch_matrices(WRIST, "line1", "fast")
    free = PeriodicPI.made(straight(WRIST, branch_slopes(WRIST)["line1"], "fast"))
    narrow = PeriodicPI(SimpleNamespace(**{**vars(free.problem), "low": 1.0}))
    expected, found = (np.array(list(pulse_response(c, a, b))) for c in (free, narrow))
    assert found == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize(
    ("low", "high", "held"), [(0.0, 4.0, 1.6), (1.0, 4.0, 2.8), (2.0, 3.0, 2.6), (-4.0, 1.0, -2.0)]
)
def test_the_wrist_is_held_two_fifths_into_its_range_from_the_end_that_is_farther_from_rest(low, high, held):
    """At rest, at 2.02 V, a wrist counts as never moved, and has no branch."""
    pi, seen = PeriodicPI.made(straight(WRIST, 0.3, "fast")), []
    problem = SimpleNamespace(**{**vars(pi.problem), "low": low, "high": high})

    def asked(at):
        seen.append(at)
        return pi.init(at)

    noted = SimpleNamespace(problem=problem, init=asked, step=pi.step)
    next(pulse_response(noted, *branch_matrices(WRIST, "line1", "fast")))
    (at,) = seen
    assert at.pressure == pytest.approx(held * WRIST.regulator.gain)
    assert at.angle == pytest.approx(0.3 * (at.pressure - WRIST.hysteresis.rest_pressure))
