"""The estimator tells the memory of a wrist at rest, and forgets what it got wrong once a line is met."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from design.controllers.measurement import memory_estimator as estimator
from design.controllers.measurement.memory_estimator import MemoryObserver, memory_at_rest, pressure_at_rest
from plants.dynamics import step
from plants.hysteresis import Memory
from plants.kernel import pytrees as tree
from plants.kernel.batches import run_lanes
from plants.wrist import STARTS, State, Wrist

WRISTS = {"flexion": Wrist.flexion(), "deviation": Wrist.deviation()}


@pytest.mark.parametrize("motion", WRISTS)
@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("angle", [0.0, 8.0, -11.0])
def test_a_wrist_at_rest_tells_its_memory(motion, start, angle):
    if start == "virgin" and angle:
        return
    wrist = WRISTS[motion]
    rest = wrist.rest(start, angle)
    memory = memory_at_rest(rest.angle, rest.pressure, wrist.hysteresis)
    assert memory.h == pytest.approx(rest.memory.h, abs=1e-12)
    # "inside" at 0 deg in flexion stands at the rest pressure: nothing tells it from a virgin wrist.
    alike = start == "inside" and rest.pressure == pytest.approx(100.0, abs=1.5) and angle == 0.0
    assert memory.virgin == (1.0 if start == "virgin" or alike else 0.0)


@given(st.floats(-19.0, 24.0), st.floats(0.0, 197.6))
def test_what_is_measured_is_projected_onto_the_loop(angle, pressure):
    p = WRISTS["deviation"].hysteresis
    low, high = p.ascending(pressure), p.descending(pressure)
    h = memory_at_rest(angle, pressure, p).h
    assert low - 1e-9 <= h <= high + 1e-9
    nearest = angle if low <= angle <= high else min((low, high), key=lambda line: abs(line - angle))
    assert h == pytest.approx(nearest, abs=estimator.NEAR_ANGLE)
    there = pressure_at_rest(angle, pressure, p)
    assert p.ascending(there) - 1e-9 <= angle <= p.descending(there) + 1e-9


def test_noise_at_rest_does_not_hide_that_the_wrist_is_virgin():
    draw, p = np.random.default_rng(1), WRISTS["flexion"].hysteresis
    memory = memory_at_rest(0.05 * draw.standard_normal(200), 100.0 + 0.3 * draw.standard_normal(200), p)
    assert (memory.virgin == 1.0).all()
    assert (memory.h == 0.0).all()


def observed(wrist, state, believed, commands, observer, noise=None):
    """Static angles, true and believed, while a wrist is moved and the observer looks on, (samples, 2)."""
    c, o = wrist.sampled(), observer.sampled()
    s = estimator.ObserverState(believed, state.angle, state.pressure)
    seen = np.zeros(len(commands)) if noise is None else noise
    rows = []
    for command, disturbed in zip(commands, seen, strict=True):
        state = step(state, command, c)
        s = estimator.step(s, state.angle + disturbed, state.pressure, o)
        rows.append((float(state.memory.h), float(s.memory.h), float(s.memory.virgin)))
    return np.array(rows)


@given(st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.sampled_from([0.6, 3.4]))
def test_a_line_wipes_out_what_was_believed_without_any_correction(true, believed, command):
    """The pressure takes either loop to the same line; from then on the two are one, to the last bit."""
    wrist = WRISTS["deviation"]
    p, pressure = wrist.hysteresis, 100.0
    low, high = p.ascending(pressure), p.descending(pressure)
    h, wrong = (low + x * (high - low) for x in (true, believed))
    assume(abs(h - wrong) > 0.1)
    state = State(pressure, Memory(h, 0.0), h)
    commands = [command] * 250 + [4.0 - command] * 100
    rows = observed(wrist, state, Memory(wrong, 0.0), commands, MemoryObserver.of(wrist, bandwidth=0.0))
    assert (rows[250:, 0] == rows[250:, 1]).all()


def test_inside_the_loop_the_angle_corrects_at_the_bandwidth_that_was_set():
    """On the transit the error obeys a double pole: (1 + b t) exp(-b t) of its start, by hand."""
    wrist, b = WRISTS["flexion"], 20.0
    state = State(100.0, Memory(0.5, 0.0), 0.5)
    rows = observed(
        wrist, state, Memory(3.0, 0.0), [100.0 / 49.4] * 400, MemoryObserver.of(wrist, b, doubt=9.0)
    )
    t = 0.001 * np.arange(1, 401)
    assert rows[:, 1] - rows[:, 0] == pytest.approx(2.5 * (1.0 + b * t) * np.exp(-b * t), abs=0.03)


def test_a_wrist_wrongly_taken_for_virgin_is_found_out():
    wrist = WRISTS["flexion"]
    state = State(100.0, Memory(4.0, 0.0), 4.0)
    rows = observed(wrist, state, Memory(0.0, 1.0), [100.0 / 49.4] * 600, MemoryObserver.of(wrist, 15.0))
    assert rows[-1, 2] == 0.0
    assert rows[-1, 1] == pytest.approx(4.0, abs=0.01)


def test_a_virgin_wrist_stays_one_in_the_dead_zone_under_noise():
    wrist = WRISTS["flexion"]
    noise = 0.03 * np.random.default_rng(3).standard_normal(600)
    rows = observed(wrist, wrist.rest(), Memory(0.0, 1.0), [2.2] * 600, MemoryObserver.of(wrist), noise)
    assert (rows[:, 2] == 1.0).all()
    assert (rows[:, 1] == 0.0).all()


def test_noise_comes_through_no_larger_than_it_is():
    wrist = WRISTS["deviation"]
    noise = 0.03 * np.random.default_rng(5).standard_normal(3000)
    commands = 2.2 + 0.9 * np.sin(np.arange(3000) * 0.004)
    rows = observed(
        wrist, wrist.rest("line1", 0.0), Memory(0.0, 0.0), commands, MemoryObserver.of(wrist), noise
    )
    assert np.sqrt(np.mean((rows[:, 0] - rows[:, 1]) ** 2)) < 0.03


def test_settings_that_make_no_sense_are_refused():
    for changes, words in (
        ({"bandwidth": -1.0}, "bandwidth"),
        ({"bandwidth": np.array([15.0, -1.0])}, "bandwidth"),
        ({"doubt": 0.0}, "doubt"),
        ({"bandwidth": float("nan")}, "finite"),
    ):
        with pytest.raises(ValueError, match=words):
            MemoryObserver.of(WRISTS["flexion"], **changes)


def test_the_observer_compiles_as_a_law():
    wrist = WRISTS["flexion"]
    c = MemoryObserver.of(wrist).sampled()
    start = estimator.init(0.0, 100.0, c)
    signals = {"angle": np.linspace(0.0, 1.0, 50), "pressure": np.linspace(100.0, 130.0, 50)}
    last, _ = run_lanes(_law, start, c, 50, signals, ("angle", "pressure"))
    s = start
    for angle, pressure in zip(signals["angle"], signals["pressure"], strict=True):
        s = estimator.step(s, angle, pressure, c)
    compiled = np.array([x[0] for x in tree.leaves(last)])
    assert compiled == pytest.approx(np.array(tree.leaves(s), float), abs=1e-12)


def _law(state, inputs, c):
    return estimator.step(state, *inputs, c)
