"""A sensor's noise has its size and hold time, its quantum is one; a part that is absent leaves no code."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest

from design.controllers.pi import PI
from design.evaluation.runner import play, step_from
from design.evaluation.steps import run
from design.robustness.samples.conditions import Conditions
from design.robustness.samples.draws import SamplingTask, noise
from plants import Wrist
from plants.effects.regulator.dead_time import DeadTime
from plants.effects.sensor.gyro_drift import Drift
from plants.kernel import pytrees as tree
from plants.kernel.batches import run_lanes
from plants.kernel.templates import emit
from plants.simulation.closed_loop import ClosedLoop, SampledClosedLoop, advance, law
from plants.simulation.reference_profile import ReferenceProfile
from plants.simulation.sensor import HOLD, Noise, Sensor, sensor

LANES, SECONDS = 21, 3.0
CONTROLLER = PI(5.0, 9.0)
DRAW = np.random.default_rng(4)
NORMAL = DRAW.standard_normal((300, LANES))
WRISTS = {
    "declared": Wrist.flexion().with_values(Tw=DRAW.uniform(0.1, 0.2, LANES)),
    "with effects": Wrist.flexion() + DeadTime(DRAW.uniform(0.0, 0.06, LANES)) + Drift(0.02),
}


def plain_loop(wrist: Wrist, seen_of: Any) -> np.ndarray:
    """Angles of one lane, the loop's halves written out; ``seen_of(angle, k)`` is what the sensor shows."""
    state, c, samples = wrist.rest(), wrist.sampled(), round(SECONDS / 0.001)
    integral, angles = state.pressure - 100.0, []
    from plants.dynamics import step

    for k in range(samples):
        angles.append(float(state.angle))
        error = 15.0 - seen_of(float(state.angle), k)
        wanted = (100.0 + 5.0 * error + integral) / 49.4
        command = min(max(wanted, 0.0), 4.0)
        if (wanted - command) * error <= 0.0:
            integral += 9.0 * error * 0.001
        state = step(state, command, c)
    return np.array(angles)


def behind(wrist: Wrist, gains: PI, reference: float, seen_by: Sensor, noise: Any, every: int, *record: str):
    """Metrics and recorded rows of a step of a loop behind a sensor."""
    lanes = replace(step_from(wrist, wrist.rest(), reference, SECONDS), sensor=seen_by, noise=noise)
    played = play(lanes, gains, signals=record, every=every)
    return played.metrics, played.rows


@pytest.mark.parametrize("plant", WRISTS)
@pytest.mark.parametrize("seen_by", [sensor(), Sensor(Noise(0.0))], ids=["no noise", "noise of size 0"])
def test_a_perfect_sensor_gives_the_plain_loop(plant, seen_by):
    wrist = WRISTS[plant]
    judged, last, _ = run(wrist, CONTROLLER, 15.0, duration=SECONDS, jobs=1)
    noise = NORMAL if seen_by.noise else None
    same, rows = behind(wrist, CONTROLLER, 15.0, seen_by, noise, 3000, "plant.angle")
    for a, b in zip(vars(judged).values(), vars(same).values(), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(rows[0, -1], last.plant.angle, rtol=1e-12)


@pytest.mark.parametrize(("size", "quantum"), [(0.5, 0.0), (0.0, 0.5), (0.5, 0.5)])
def test_the_loop_is_the_one_written_out(size, quantum):
    wrist = Wrist.flexion()

    def seen(angle: float, k: int) -> float:
        shown = angle + size * NORMAL[k // HOLD, 0]
        return quantum * np.floor(shown / quantum + 0.5) if quantum else shown

    given = NORMAL[:, :1] if size else None
    _, rows = behind(wrist, CONTROLLER, 15.0, sensor(size, quantum), given, 1, "plant.angle")
    np.testing.assert_allclose(rows[0, :-1, 0], plain_loop(wrist, seen), atol=1e-9)


class Heard(NamedTuple):
    last: Any


class Nothing(NamedTuple):
    gain: Any


def listen(s: Heard, inputs: tuple[Any, Any], c: Nothing) -> Heard:
    return Heard(c.gain * inputs[1] + 0.0 * inputs[0])


@pytest.mark.parametrize("lanes", [32, 21, 1])
def test_each_lane_hears_its_own_signal_held_for_so_many_steps(lanes):
    own = DRAW.standard_normal((7, lanes))
    for jobs in (1, 2):
        _, rows = run_lanes(
            listen, Heard(np.zeros(lanes)), Nothing(2.0), 65, {}, ("sample", "own"),
            1, ("last",), jobs, {"own": own}, 10,
        )  # fmt: skip
        np.testing.assert_array_equal(rows[0, 1:], 2.0 * np.repeat(own, 10, axis=0)[:65])


def test_commands_of_each_lane_have_a_row_for_every_sample():
    wrist, volts = Wrist.flexion(), np.repeat(DRAW.uniform(0.0, 4.0, (40, 3)), 5, axis=0)
    c = SampledClosedLoop(wrist.sampled(), (), ReferenceProfile((0.0,)))
    last, _ = advance(ClosedLoop(wrist.rest()), c, 200, own={"command": volts}, jobs=1)
    for lane in range(3):
        alone = wrist.simulate(volts[:, lane]).state
        np.testing.assert_allclose(last.plant.pressure[lane], alone.pressure, rtol=1e-12)
        np.testing.assert_allclose(last.plant.angle[lane], alone.angle, rtol=1e-12)


def test_a_signal_of_one_lane_is_heard_by_all_and_a_short_one_is_refused():
    own = DRAW.standard_normal((2, 1))
    last, _ = run_lanes(
        listen, Heard(np.zeros(3)), Nothing(1.0), 20, {}, ("sample", "own"), held={"own": own}, hold=10
    )
    np.testing.assert_array_equal(last.last, np.full(3, own[1, 0]))
    with pytest.raises(ValueError, match="shorter than the 21 steps"):
        run_lanes(
            listen, Heard(np.zeros(3)), Nothing(1.0), 21, {}, ("sample", "own"), held={"own": own}, hold=10
        )


def test_noise_in_the_kernel_has_its_standard_deviation_and_its_hold_time():
    """Kp alone on a wrist whose command does not clip: command = (100 + Kp (r - seen)) / gain, so that
    the command, the true angle taken off, shows the noise itself."""
    from design.robustness.box import box_of
    from plants.parameters.files import built_in

    size, Kp, lanes = 0.2, 2.0, 64
    task = SamplingTask(box_of(built_in("flexion")), CONTROLLER, Conditions(0, 0, size, 0), 5, 15.0, 10.0)
    drawn = noise(task, 0, lanes)
    assert drawn is not None
    wrist = Wrist.flexion().with_values(Tw=np.full(lanes, 0.16))
    _, rows = behind(wrist, PI(Kp, 0.0), 5.0, sensor(size), drawn, 1, "plant.angle", "judge.command")
    angle, command = rows[0, :-1], rows[1, 1:]
    heard = 5.0 - (49.4 * command - 100.0) / Kp - angle
    steps = np.abs(np.diff(heard, axis=0)) > 1e-9
    assert steps[9::10].all()  # new every 10 ms ...
    assert not np.delete(steps, np.s_[9::10], axis=0).any()  # ... and held in between
    values = heard[::10]
    n = values.size
    # Standard deviations of the estimates: size / sqrt(2 n), 1 / sqrt(n), of the mean size / sqrt(n).
    assert abs(values.std() - size) < 4.0 * size / np.sqrt(2 * n)
    assert abs(values.mean()) < 4.0 * size / np.sqrt(n)
    next_to = np.corrcoef(values[:-1].ravel(), values[1:].ravel())[0, 1]
    beside = np.corrcoef(values[:, :-1].ravel(), values[:, 1:].ravel())[0, 1]
    assert max(abs(next_to), abs(beside)) < 4.0 / np.sqrt(n)


def test_a_quantum_rounds_to_the_nearest_and_in_the_kernel_as_in_numpy():
    shown = sensor(0.0, 0.5).shows(np.array([-0.26, -0.24, 0.0, 0.24, 0.25, 7.74]))
    np.testing.assert_allclose(shown, [-0.5, 0.0, 0.0, 0.0, 0.5, 7.5])

    def law(s: Heard, _inputs: tuple[()], c: Nothing) -> Heard:
        return Heard(np.floor(s.last) + 0.0 * c.gain)

    x = DRAW.normal(0.0, 1e6, 64)
    x[:4] = -2.0, 3.0, -0.5, 0.0
    last, _ = run_lanes(law, Heard(x), Nothing(1.0), 1)
    np.testing.assert_array_equal(last.last, np.floor(x))


def code(seen_by: Sensor, names: tuple[str, ...] = ("sample",)) -> str:
    """Emitted code of a loop, of which a line for every leaf of the state and the coefficients."""
    first, c = step_from(Wrist.flexion(), Wrist.flexion().rest(), 15.0).loop(CONTROLLER)
    c = c._replace(sensor=seen_by)
    if "command" in names:
        first, c = first._replace(controller=()), c._replace(controller=())
    first, c = (tree.like(t, tree.names(t)) for t in (first, c))
    return emit("loop", law(names), first, names, c, tuple(n for n in names if n == "noise"))


def test_parts_that_are_absent_leave_no_code():
    plain = code(sensor())
    assert "held" not in plain
    assert "floor" not in plain
    noisy = code(sensor(0.1), ("sample", "noise"))
    assert "held" in noisy
    assert "floor" not in noisy
    assert "floor" in code(sensor(0.0, 0.1))
    # A replay has neither the law of a controller nor rows for its state.
    given = code(sensor(), ("sample", "command"))
    assert given.count("\n") < plain.count("\n") - 8
