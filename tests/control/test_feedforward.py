"""The feedforward is exact: a wrist like its model follows the model, and the model keeps the range."""

from dataclasses import replace

import numpy as np
import pytest

from design.controllers.controller import Measured, stacked
from design.controllers.feedforward import Feedforward, FeedforwardPI
from design.controllers.pi import PI
from design.controllers.reference_model import _time, no_inverse, reachable, within_reach
from design.evaluation.cases import Case, stack
from design.evaluation.runner import play, step_from
from design.evaluation.steps import run
from design.evaluation.tasks import Task
from plants import one_page
from plants.actuator import regulator
from plants.effects.regulator.dead_time import DeadTime
from plants.effects.wrist.creep import Creep
from plants.effects.wrist.load_step import LoadStep
from plants.errors import InputError, InputWarning
from plants.kernel import pytrees as tree
from plants.simulation.closed_loop import OutsideSignals, step
from plants.wrist import STARTS, Wrist

WRISTS = {"flexion": Wrist.flexion(), "deviation": Wrist.deviation()}


def starts(wrist):
    """States and references of the 15 degree steps, both signs from every starting memory."""
    tasks = [(start, sign * 15.0) for sign in (1, -1) for start in STARTS]
    leaves = np.array([tree.leaves(wrist.rest(start)) for start, _ in tasks], float)
    return tree.like(wrist.rest(), list(leaves.T)), np.array([r for _, r in tasks])


def played(wrist, controller, reference, samples):
    """Commands and the model's angles of a controller that is shown nothing but its reference."""
    c, state = controller.sampled(), controller.holding(wrist.rest().pressure)
    commands, angles = [], [float(state.course.model.angle)]
    for k in range(samples):
        state, command = c.act(state, Measured(reference(k), 0.0, 0.0))
        commands.append(float(command))
        angles.append(float(state.course.model.angle))
    return np.array(commands), np.array(angles)


@pytest.mark.parametrize("motion", WRISTS)
def test_the_page_replays_the_commands_to_the_models_angle(motion):
    wrist = WRISTS[motion]

    def staircase(k):
        return (12.0, -12.0, 3.0, 3.5)[k // 500]

    commands, angles = played(wrist, Feedforward.of(wrist), staircase, 2000)
    replayed = np.array([row[2] for row in one_page.wrist(wrist.values, list(commands))])
    assert np.abs(replayed - angles).max() < 1e-9
    assert commands.min() >= 0.0
    assert commands.max() <= 4.0
    for k, r in ((499, 12.0), (999, -12.0), (1499, 3.0), (1999, 3.5)):
        assert replayed[k] == pytest.approx(r, abs=0.02)


@pytest.mark.parametrize("motion", WRISTS)
def test_close_to_the_reference_the_angle_obeys_the_filter(motion):
    wrist, speed = WRISTS[motion], 12.0
    _, angles = played(wrist, Feedforward.of(wrist, speed=speed), lambda k: 10.0, 900)
    off = 10.0 - angles
    close = np.flatnonzero((off < 0.2) & (off > 1e-3))
    assert close.size > 50
    shrinks = off[close[1:]] / off[close[:-1]]
    # d/dt (r - y) = -speed (r - y), met once a sample of 1 ms.
    assert shrinks == pytest.approx(np.exp(-speed * 0.001), abs=2e-4)


@pytest.mark.parametrize("motion", WRISTS)
@pytest.mark.parametrize("speed", [4.0, 12.0, 25.0, 60.0])
def test_steps_overshoot_nothing_worth_the_name_and_do_not_chatter(motion, speed):
    wrist = WRISTS[motion]
    state, reference = starts(wrist)
    judged, _, _ = run(wrist, Feedforward.of(wrist, speed=speed), reference, state, duration=2.0)
    assert judged.overshoot_percent.max() < 0.1
    assert judged.total_variation_V.max() < 12.0  # up, down, and to where the reference is held: 4 + 4 + 4
    assert judged.steady_state_error_deg.max() < 0.01


@pytest.mark.parametrize(("motion", "gains"), [("flexion", (3.13, 10.4)), ("deviation", (6.76, 19.7))])
def test_it_settles_far_ahead_of_the_plain_pi_where_the_model_is_right(motion, gains):
    wrist = WRISTS[motion]
    state, reference = starts(wrist)
    plain, _, _ = run(wrist, PI(*gains), reference, state)
    ours, _, _ = run(wrist, FeedforwardPI.of(wrist, Kp=gains[0], Ki=gains[1]), reference, state)
    assert (ours.iae_deg_s < 0.75 * plain.iae_deg_s).all()
    assert ours.settling_time_s.max() < 0.25 * plain.settling_time_s.max()


def test_the_integrator_stands_still_while_the_command_is_clipped_and_the_error_pushes_out():
    controller = FeedforwardPI.of(WRISTS["flexion"], Kp=3.0, Ki=10.0)
    c, state = controller.sampled(), controller.holding(100.0)

    def trim_after(angle, trim):
        """From rest on the way to 15 deg at full throttle, where the model expects 0 deg."""
        after, command = c.act(
            state._replace(trim=trim, reference=15.0), Measured(15.0 - angle, angle, 100.0)
        )
        return float(after.trim), float(command)

    assert trim_after(-5.0, 20.0) == (20.0, 4.0)  # pushes out
    trim, command = trim_after(5.0, 20.0)  # drives back, the command still clipped
    assert (trim, command) == (pytest.approx(20.0 - 10.0 * 0.001 * 5.0), 4.0)
    trim, command = trim_after(5.0, 0.0)  # in the range
    assert trim == pytest.approx(-10.0 * 0.001 * 5.0)
    assert command == pytest.approx(4.0 - 3.0 * 5.0 / 49.4)


def test_compiled_lanes_and_plain_python_agree():
    wrist = WRISTS["deviation"].with_values(w1=4.1)
    controller = FeedforwardPI.of(WRISTS["deviation"], Kp=3.0, Ki=9.0)
    _, _, compiled = run(wrist, controller, 9.0, duration=0.4, record=True)
    rest = wrist.rest()
    held = controller.holding(rest.pressure, Measured(0.0, 0.0, rest.pressure))
    loop, c = step_from(wrist, rest, 9.0).loop(controller, held)
    angles = []
    for k in range(400):
        angles.append(float(loop.plant.angle))
        loop = step(loop, OutsideSignals(float(k)), c)
    assert compiled.angle[:400, 0] == pytest.approx(np.array(angles), abs=1e-9)


def test_the_pi_takes_out_a_constant_load_and_the_feedforward_alone_does_not():
    wrist = WRISTS["flexion"]
    loaded = wrist + LoadStep(shift=2.0, moment=1.0)
    with_pi, _, _ = run(loaded, FeedforwardPI.of(wrist, Kp=3.0, Ki=10.0), 10.0)
    alone, _, _ = run(loaded, Feedforward.of(wrist), 10.0)
    assert with_pi.steady_state_error_deg[0] < 0.02
    assert alone.steady_state_error_deg[0] > 0.5


def test_a_dead_time_that_is_known_costs_less_than_one_that_is_not():
    wrist = WRISTS["flexion"] + DeadTime(0.05)
    settings = {"Kp": 6.0, "Ki": 15.0, "speed": 15.0}
    known, _, _ = run(wrist, FeedforwardPI.of(wrist, **settings), 15.0)
    unknown, _, _ = run(wrist, FeedforwardPI.of(wrist, dead_time=0.0, **settings), 15.0)
    alone, _, _ = run(wrist, Feedforward.of(wrist, speed=15.0), 15.0)
    assert known.settling_time_s[0] == pytest.approx(alone.settling_time_s[0], abs=1e-9)
    assert known.iae_deg_s[0] < unknown.iae_deg_s[0]


@pytest.mark.parametrize("start", STARTS)
def test_it_holds_what_it_is_told_to_hold(start):
    wrist = WRISTS["deviation"].with_values(w1=5.0, w2=2.5)  # not the loop that it believes in
    rest = wrist.rest(start, 0.0)
    for controller in (
        Feedforward.of(WRISTS["deviation"]),
        FeedforwardPI.of(WRISTS["deviation"], Kp=2.0, Ki=5.0),
    ):
        seen = Measured(0.0, rest.angle, rest.pressure)
        state = controller.holding(rest.pressure, seen)
        assert controller.command(state) * 49.4 == pytest.approx(rest.pressure, abs=1e-9)
        for _ in range(50):
            state, command = controller.sampled().act(state, seen)
            assert command * 49.4 == pytest.approx(rest.pressure, abs=1e-9)


def test_a_reference_out_of_reach_is_clamped_and_counted():
    wrist = WRISTS["flexion"]
    low, high = reachable(wrist)
    _, last, _ = run(wrist, FeedforwardPI.of(wrist, Kp=3.0, Ki=10.0), 40.0, duration=10.0)
    assert float(last.plant.angle[0]) == pytest.approx(high, abs=0.1)
    assert float(last.controller.course.outside[0]) == 10_000
    _, last, _ = run(wrist, Feedforward.of(wrist), 20.0, duration=0.1)
    assert float(last.controller.course.outside[0]) == 0
    with pytest.warns(InputWarning, match=r"out of reach \(-30\.00 to 29\.14 deg\): 29\.14 deg is taken"):
        assert within_reach(wrist, 40.0) == high
    with pytest.warns(InputWarning, match=r"-30\.00 deg is taken"):
        assert within_reach(wrist, -40.0) == low
    assert within_reach(wrist, 12.0) == 12.0
    with pytest.raises(InputError, match="finite"):
        within_reach(wrist, float("nan"))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"a1": 0.05}, "s = 0.0803 is not below a1 = 0.05.*use a PI"),
        ({"a2": 0.0, "s": 0.0}, "s = 0 is not below a2 = 0.*use a PI"),
        ({"w1": 1.0, "w2": 1.0, "a2": 0.3}, "line 1 lies above line 2.*use a PI"),
    ],
)
def test_a_loop_that_cannot_be_inverted_is_refused(changes, words):
    with pytest.raises(InputError, match=words) as caught:
        Feedforward.of(WRISTS["flexion"].with_values(**changes))
    assert "\n" not in str(caught.value)


def test_effects_without_an_inverse_are_named():
    wrist = WRISTS["flexion"] + Creep(0.1, 4.0) + DeadTime(0.05)
    with pytest.raises(InputError, match=r"the effect creep: invert the wrist without it.*or use a PI"):
        Feedforward.of(wrist)
    assert no_inverse(WRISTS["flexion"] + DeadTime(0.05)) is None


@pytest.mark.parametrize(
    "changes", [{"speed": 0.0}, {"s": 0.4}, {"k_slow": 20.0}, {"Tw": np.nan}, {"w1": -7.0}, {"Ki": -1.0}]
)
def test_settings_that_make_no_sense_are_refused(changes):
    model = WRISTS["flexion"]
    model = model.with_values(**{n: v for n, v in changes.items() if n in model.values})
    settings = {"Kp": 1.0, "Ki": 1.0, **{n: v for n, v in changes.items() if n not in model.values}}
    with pytest.raises(ValueError, match=r"."):
        FeedforwardPI(model, **settings)


@pytest.mark.parametrize("name", ["Tw", "w1", "rest_pressure"])
def test_one_setting_that_is_no_number_among_others_is_told(name):
    with pytest.raises(ValueError, match="must be finite"):
        Feedforward(WRISTS["flexion"].with_values(**{name: np.nan}))


def test_controllers_stack_into_lanes():
    wrist = WRISTS["flexion"]
    apart = [FeedforwardPI.of(wrist, speed=v, Kp=2.0, Ki=8.0) for v in (8.0, 20.0)]
    both, _, _ = run(wrist, stacked(apart), np.full(2, 15.0), duration=1.0)
    for i, controller in enumerate(apart):
        one, _, _ = run(wrist, controller, 15.0, duration=1.0)
        assert one.iae_deg_s[0] == both.iae_deg_s[i]


@pytest.mark.parametrize("load", [0.0, 1.0])
def test_after_a_step_that_was_taken_back_behind_dead_time_it_starts_from_the_wrists_branch(load):
    # A model that kept its own memory overshot by 15 and 31 % of the last step here.
    wrist = WRISTS["flexion"]
    task = Task("virgin", 0.0, (15.0, 10.0, 5.0), (0.3, 3.4, 10.0), load=load)
    taken_back = Case(task, wrist, dead_time=0.05)
    controller = FeedforwardPI.of(wrist, Kp=3.0, Ki=8.0, speed=3.0, dead_time=0.025)
    found = play(stack([taken_back]), controller).metrics
    assert found.overshoot_percent[0] < 1.0
    assert found.settling_time_s[0] < 1.5


@pytest.mark.parametrize("held", [False, True])
def test_the_model_starts_from_the_wrist_where_a_held_reference_is_left_and_goes_on_along_a_ramp(held):
    controller = FeedforwardPI.of(WRISTS["flexion"], Kp=3.0, Ki=8.0)
    c, begun = controller.sampled(), controller.holding(100.0)

    def pressures(measured):
        state, found = begun, []
        for k in range(6):
            reference = 1.0 + 0.1 * (3 * (k // 3) if held else k)
            state, _ = c.act(state, Measured(reference, 0.0, 100.0 if k == 0 else measured))
            found.append(float(state.course.model.pressure))
        return found

    one, other = pressures(100.0), pressures(104.0)
    assert one[:3] == other[:3]
    assert (one[3:] == other[3:]) is not held
    if held:
        assert other[3] - one[3] > 2.0


@pytest.mark.parametrize("end", [1.0, 3.0])
def test_lines_may_cross_beyond_the_pressures_that_its_range_comes_to_and_not_within(end):
    """Of a range from 1 to 3 V: a gap of the lines that closes a little before an end, or a little beyond."""
    wrist = Wrist.flexion()
    p, gain = wrist.hysteresis, wrist.regulator.gain
    for beyond, refused in ((0.97, True), (1.03, False)):
        way = (gain * end - p.rest_pressure) * beyond
        crossed = wrist.with_values(a2=float(p.a1 - (p.w1 + p.w2) / way))
        if refused:
            with pytest.raises(ValueError, match="line 1 lies above line 2"):
                FeedforwardPI(crossed, low=1.0, high=3.0)
        else:
            assert FeedforwardPI(crossed, low=1.0, high=3.0).high == 3.0


def test_a_pi_without_gains_leaves_the_feedforward_alone_whatever_the_wrist_does():
    wrist, commands = WRISTS["flexion"], []
    for controller in (Feedforward.of(wrist), FeedforwardPI.of(wrist)):
        c, state, sent = controller.sampled(), controller.holding(wrist.rest().pressure), []
        for k in range(300):
            angle = 2.0 * np.sin(k / 40.0)  # nothing that the model does
            state, command = c.act(state, Measured(8.0 - angle, angle, 100.0 + k / 10.0))
            sent.append(float(command))
        commands.append(sent)
    assert commands[0] == commands[1]
    assert FeedforwardPI.of(wrist).dead_time == 0.0


def test_a_reference_beyond_a_range_that_does_not_begin_at_zero_is_counted():
    wrist = Wrist.flexion()
    narrow = replace(wrist, rig=replace(wrist.rig, command_range=(1.0, 3.0)))
    gain, loop = wrist.regulator.gain, wrist.hysteresis
    least, less = (float(loop.clamped(-90.0, v * gain, 4.0 * gain)) for v in (1.0, 0.5))
    assert less < least
    for plant, reference, beyond in ((narrow, 0.5 * (less + least), 10), (wrist, 0.5 * (less + least), 0)):
        feedforward = Feedforward.of(plant)
        state, course = feedforward.holding(plant.rest().pressure), feedforward.sampled()
        for _ in range(10):
            state, _ = course.act(state, Measured(reference, 0.0, 0.0))
        assert float(state.course.outside) == beyond


@pytest.mark.parametrize(
    ("before", "after", "target"), [(150.0, 50.0, 0.0), (20.0, 1.2, 0.0), (100.0, 195.9, 197.6)]
)
def test_braking_takes_as_long_as_the_regulator_does_whose_rate_is_the_same_at_every_error(
    before, after, target
):
    """Of the last kPa, which takes for ever, nothing is counted, nor of a way that the brake does not go."""
    c = Feedforward.of(Wrist.flexion().with_values(k_slow=5.0, k_fast=5.0))._sampled_course(0.001)
    pressure, samples = before, 0
    while abs(pressure - target) > abs(after - target):
        pressure = regulator.step(pressure, target / c.wrist.regulator.gain, c.wrist.regulator)
        samples += 1
    assert 0.001 * (samples - 1) <= float(_time(before, after, target, c)) <= 0.001 * samples
    near = target + np.sign(before - target) * np.array([1.0, 0.3, 0.0])
    np.testing.assert_allclose(_time(before, near, target, c), np.log(abs(before - target)) / 5.0)
    assert float(_time(before, before + 10.0 * np.sign(before - target), target, c)) == 0.0
