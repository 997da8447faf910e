"""The loop around an MPC is the plant of `design.evaluation.steps`, sample by sample: judge, dead time."""

import numpy as np
import pytest

from design.controllers.controller import Measured
from design.controllers.pi import PI
from design.evaluation.steps import run as run_pi
from design.mpc.fallback import Info, MPCState
from design.mpc.formulations.real_time import real_time_mpc
from design.mpc.loop import run
from design.mpc.problem import MPCProblem
from plants import Wrist
from plants.effects.regulator.dead_time import DeadTime, TubeDeadTime
from plants.effects.sensor.gyro_drift import Drift
from plants.effects.sensor.periodic import Hum
from plants.effects.wrist.load_step import LoadStep
from plants.simulation.sensor import HOLD, sensor

GAINS = PI(1.5, 4.0)


class SampledPIAsMPC:
    """A PI that acts once a sample, dressed as a periodic controller."""

    problem = MPCProblem(Wrist.flexion(), period=0.001)

    def init(self, seen):
        pressure = float(seen.pressure)
        return MPCState(None, pressure / GAINS.gain, 0.0, None, None, None, 0, GAINS.holding(pressure))

    def step(self, state, seen):
        after, command = GAINS.sampled().act(state.pi, seen)
        return state._replace(pi=after), float(command), Info("solved", "", 0, 0, 0, 0)


@pytest.mark.parametrize(
    "effects",
    [
        (),
        (DeadTime(0.0374),),
        (TubeDeadTime(0.02, 0.03), LoadStep(1.0, 0.2)),
        (Drift(1.5), Hum(2.0, 0.3, 0.2)),
    ],
    ids=["declared", "dead time", "tube and load", "drift and hum"],
)
def test_a_pi_is_played_as_design_loop_plays_it(effects):
    wrist = Wrist.flexion()
    for effect in effects:
        wrist = wrist + effect
    play = run(wrist, SampledPIAsMPC(), 15.0, duration=0.7, record=True)
    metrics, _, trajectory = run_pi(wrist, GAINS, 15.0, duration=0.7, record=True)
    assert np.abs(play.trajectory.angle - trajectory.angle).max() < 1e-10
    assert np.abs(play.trajectory.pressure - trajectory.pressure).max() < 1e-9
    assert np.abs(play.trajectory.command - trajectory.command)[:-1].max() < 1e-10
    for name, value in vars(metrics).items():
        np.testing.assert_allclose(getattr(play.metrics, name), value, rtol=1e-9, atol=1e-9)


def test_the_sensor_is_quantised_and_its_noise_repeats():
    wrist, seen = Wrist.flexion(), []

    class Spy(SampledPIAsMPC):
        def step(self, state, measured):
            seen.append(measured.angle)
            return super().step(state, measured)

    noise = np.random.default_rng(3).standard_normal((20, 1))
    for _ in range(2):
        run(wrist, Spy(), 15.0, duration=0.2, sensor=sensor(0.2, 0.05), noise=noise)
    angles = np.array(seen).reshape(2, -1)
    assert (angles[0] == angles[1]).all()
    assert np.abs(angles / 0.05 - np.round(angles / 0.05)).max() < 1e-9
    fresh = angles[0][::HOLD]
    assert 0.1 < np.std(np.diff(fresh)) / np.sqrt(2.0) < 0.4
    # Held in between: the joint has not moved by a quantum yet.
    assert np.ptp(angles[0, : 5 * HOLD].reshape(-1, HOLD), axis=1).max() == 0.0


@pytest.mark.parametrize("start", ["line1", "line2", "virgin"])
def test_the_memory_at_the_start_is_read_off_angle_and_pressure(start):
    """The controller is not told on which branch the wrist rests."""
    wrist = Wrist.flexion()
    rest = wrist.rest(start)
    controller = real_time_mpc(MPCProblem(wrist))
    believed = controller.init(Measured(0.0, float(rest.angle), float(rest.pressure))).believed
    memory = [float(x) for x in believed.plant.memory]
    assert memory == pytest.approx([float(x) for x in rest.memory], abs=1e-9)
    assert (believed.lack, believed.shift) == pytest.approx((0.0, 0.0), abs=1e-9)


@pytest.mark.parametrize("wrist", [Wrist.flexion(), Wrist.flexion() + Drift(1.5)], ids=["declared", "drift"])
def test_a_run_in_two_parts_is_the_run(wrist):
    """The second shows what a sensor does that long after the start of the first."""
    controller = real_time_mpc(MPCProblem(Wrist.flexion()))
    whole = run(wrist, controller, 15.0, duration=0.6, record=True)
    first = run(wrist, controller, 15.0, duration=0.3)
    second = run(wrist, controller, 15.0, first.last.plant, 0.3, True, begin=0.3, memory=first.controller)
    np.testing.assert_allclose(second.trajectory.angle[:, 0], whole.trajectory.angle[300:, 0], rtol=1e-9)
