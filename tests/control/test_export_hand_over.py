"""A PI takes over from a command by hand without a jump at any error, and keeps its rate limit."""

import math
import re
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from design.controllers.controller import Measured
from design.controllers.hand_over import HandOver, step
from design.controllers.pi import PI
from design.controllers.pi_two_dof import TwoDofPI
from design.export.catalogue import part
from design.export.formats.fmu import unit
from design.export.formats.folder import contents
from design.export.formats.structured_text import function_block
from design.export.formats.targets import VERSIONS
from design.export.table import difference_in_c, difference_in_unit
from design.export.vectors import TargetReplay, vector
from plants import InputError
from tests.control.c_target import WRIST, needs_compiler
from tests.control.test_export_plant import Unit
from tests.control.test_export_st import translated

GAINS = {"pi": (3.1, 10.4), "pi-2dof": (3.1, 10.4, 0.7, 0.01)}
OPTIONS = {"hand-over": (True, None), "rate": (False, 20.0), "both": (True, 20.0)}
STEPS = 3000
LARGE = 1e-9
"""What Python and C may differ by [V]."""

gains = st.floats(0.0, 1e4)
angles = st.floats(-80.0, 80.0)
commands = st.floats(0.0, 4.0)


@st.composite
def controllers(draw):
    pi = (draw(gains), draw(gains))
    kind = draw(st.booleans())
    made = (
        TwoDofPI.of(WRIST, *pi, draw(st.floats(0.0, 2.0)), draw(st.sampled_from([0.0, 0.01, 0.1])))
        if kind
        else PI.of(WRIST, *pi)
    )
    return HandOver(made, draw(st.sampled_from([math.inf, 20.0, 0.5])))


def seen(reference, angle):
    return Measured(reference - angle, angle, 100.0)


@given(controllers(), st.lists(st.tuples(angles, angles, commands), min_size=1, max_size=8), angles, angles)
def test_the_first_automatic_command_is_the_last_by_hand(controller, by_hand, reference, angle):
    c = controller.sampled(0.001)
    state = controller.holding(100.0, seen(0.0, 0.0))
    for r, y, wanted in by_hand:
        state, last = step(state, seen(r, y), 1.0, wanted, c)
    _, first = step(state, seen(reference, angle), 0.0, 0.0, c)
    assert float(first) == float(last)


@given(controllers(), angles, angles, commands)
def test_it_goes_on_from_there_as_its_integral_does(controller, reference, angle, wanted):
    c, still = controller.sampled(0.001), seen(reference, angle)
    state = controller.holding(100.0, still)
    for _ in range(300):  # the filter comes to rest
        state, last = step(state, still, 1.0, wanted, c)
    for _ in range(2):
        state, second = step(state, still, 0.0, 0.0, c)
    most = controller.pi.Ki * 0.001 * abs(reference - angle) / controller.gain
    rounding = 1e-12 * (1.0 + controller.pi.Kp * 400.0)
    settling = (
        controller.pi.Kp * math.exp(-0.3 / 0.1) * 160.0 / controller.gain
        if hasattr(controller.pi, "Tf")
        else 0.0
    )
    assert abs(float(second - last)) <= most + rounding + settling


@given(
    controllers(),
    st.lists(st.tuples(angles, angles, st.booleans(), st.floats(-10.0, 10.0)), min_size=2, max_size=60),
)
def test_the_command_stays_in_its_range_and_within_its_rate(controller, samples):
    c = controller.sampled(0.001)
    state = controller.holding(100.0, seen(0.0, 0.0))
    last = float(state.given)
    for r, y, hand, wanted in samples:
        state, command = step(state, seen(r, y), float(hand), wanted, c)
        assert controller.low <= float(command) <= controller.high
        assert abs(float(command) - last) <= controller.rate * 0.001 * (1.0 + 1e-9) + 1e-15
        last = float(command)


@pytest.mark.parametrize("kind", GAINS)
def test_the_integrator_does_not_wind_up_at_the_rate_limit(kind):
    pi = {"pi": PI, "pi-2dof": TwoDofPI}[kind].of(WRIST, *GAINS[kind])
    slow, c = HandOver(pi, 0.5), HandOver(pi, 0.5).sampled(0.001)
    state = slow.holding(100.0, seen(0.0, 0.0))
    # Five seconds at an error that asks for more than range and rate allow, then one the other way.
    for _ in range(5000):
        state, command = step(state, seen(60.0, 0.0), 0.0, 0.0, c)
    assert float(command) == slow.high
    most = slow.gain * slow.high - pi.rest_pressure + pi.Kp * 60.0
    assert abs(float(state.automatic.integral)) <= most
    falls = []
    for _ in range(200):
        state, after = step(state, seen(-60.0, 0.0), 0.0, 0.0, c)
        falls.append(float(command - after))
        command = after
    assert falls == pytest.approx([0.5 * 0.001] * 200, abs=1e-12)  # at once, as fast as it may


def test_without_a_limit_and_a_hand_it_is_the_pi():
    c, plain = HandOver(PI.of(WRIST, 3.1, 10.4)), PI.of(WRIST, 3.1, 10.4)
    state, own, draw = c.holding(100.0), plain.holding(100.0), np.random.default_rng(1)
    for r, y in draw.uniform(-40.0, 40.0, (500, 2)):
        state, command = c.sampled(0.001).act(state, seen(r, y))
        own, expected = plain.sampled(0.001).act(own, seen(r, y))
        assert float(command) == float(expected)


def exported(kind, option):
    return part(kind, "flexion", WRIST, GAINS[kind], *OPTIONS[option])


@pytest.mark.slow
@needs_compiler
@pytest.mark.parametrize("option", OPTIONS)
@pytest.mark.parametrize("kind", GAINS)
def test_c_and_units_replay_the_vector(kind, option):
    made = exported(kind, option)
    found = vector(made, WRIST, STEPS)
    assert made.by_hand == OPTIONS[option][0]
    assert difference_in_c(made, found) <= LARGE
    assert difference_in_c(made.at("single"), found) <= made.at("single").tolerance
    pytest.importorskip("fmpy")
    assert difference_in_unit(made, found, "3.0") <= LARGE
    assert difference_in_unit(made, found, "2.0") <= LARGE


@pytest.mark.parametrize("option", OPTIONS)
@pytest.mark.parametrize("kind", GAINS)
def test_structured_text_replays_the_vector(kind, option):
    made = exported(kind, option)
    found = vector(made, WRIST, STEPS)
    variables, run = translated(function_block(made))
    block = SimpleNamespace(**variables)
    block.start_pressure_kPa, block.start_angle_deg = found.pressure, found.angle
    worst = 0.0
    for row in found.rows:
        for i, f in made.read:
            setattr(block, f.member, float(row[i]))
        run(block)
        worst = max(worst, abs(getattr(block, made.output.member) - row[-1]))
    assert worst <= LARGE


@pytest.mark.parametrize("kind", GAINS)
def test_the_vector_takes_over_many_times_and_each_time_without_a_jump(kind):
    made = exported(kind, "hand-over")
    found = vector(made, WRIST, STEPS)
    manual, output = found.rows[:, 3], found.rows[:, -1]
    taken = np.flatnonzero((manual[1:] == 0.0) & (manual[:-1] == 1.0)) + 1
    assert len(taken) > 5
    np.testing.assert_array_equal(output[taken], output[taken - 1])
    limited = vector(exported(kind, "both"), WRIST, STEPS).rows[:, -1]
    assert np.abs(np.diff(limited)).max() <= 20.0 * 0.001 * (1.0 + 1e-9)


@needs_compiler
def test_fmpy_finds_nothing_wrong_with_the_unit(tmp_path):
    pytest.importorskip("fmpy")
    from fmpy.validation import validate_fmu

    made = exported("pi", "both")
    for fmi in VERSIONS:
        (tmp_path / f"{fmi}.fmu").write_bytes(unit(made, contents(made, WRIST, 60), fmi))
        assert validate_fmu(str(tmp_path / f"{fmi}.fmu")) == []


def test_by_hand_the_command_goes_through_where_no_sensor_is_believed():
    made = exported("pi", "hand-over")
    law = TargetReplay(made)
    law.begin(100.0, 0.0)
    assert law.step(made.seen(math.nan, math.nan, math.nan, 1.0, 3.25)) == 3.25
    assert law.step(made.seen(0.0, math.nan, 0.0, 0.0, 1.0)) == 3.25  # automatic: held
    assert law.step(made.seen(0.0, 0.0, 0.0, 1.0, math.nan)) == 3.25
    assert law.step(made.seen(5.0, 0.0, 0.0, 0.0, 1.0)) == 3.25  # takes over


@pytest.mark.parametrize(
    ("kind", "option", "words"),
    [
        ("lqi", (True, None), "--hand-over: lqi has none; choose pi or pi-2dof"),
        ("observer", (False, 1.0), "--rate-limit: observer has none"),
        ("pi", (False, 0.0), "--rate-limit: 0 V/s is no rate"),
        ("pi", (False, math.nan), "--rate-limit: nan V/s is no rate"),
    ],
)
def test_what_has_none_is_refused_in_a_line(kind, option, words):
    with pytest.raises(InputError, match=re.escape(words)) as refused:
        part(kind, "flexion", WRIST, GAINS.get(kind), *option)
    assert "\n" not in str(refused.value)


def test_the_readme_tells_what_it_does():
    told = " ".join(contents(exported("pi", "both"), WRIST, 60)["README.md"].split())
    assert "the first automatic command is the last one by hand" in told
    assert "never moves faster than the rate limit" in told
    assert "rate limit | 20.0" in told


@needs_compiler
@pytest.mark.parametrize("kind", GAINS)
def test_whatever_it_is_told_the_unit_gives_what_python_gives_within_range_and_rate(kind, tmp_path):
    made = exported(kind, "both")
    one = Unit(unit(made, contents(made, WRIST, 60), "3.0"), "3.0", tmp_path / "fmu")
    law, draw = TargetReplay(made), np.random.default_rng(5)
    last = law.begin(100.0, 0.0)
    one.start(start_pressure_kPa=100.0, start_angle_deg=0.0)
    hostile = (math.nan, math.inf, -math.inf, 1e308, -1e308, 1e9, 0.0, 0.5, 1.0, 2.0)
    for k in range(3000):
        near = (*draw.uniform(-20.0, 20.0, 2), 0.0, float(draw.integers(0, 2)), draw.uniform(-1.0, 5.0))
        told = [float(draw.choice(hostile)) if draw.uniform() < 0.1 else x for x in map(float, near)]
        one.put(**{f.member: told[i] for i, f in made.read})
        one.loaded.doStep(k * made.period, made.period)
        (command,) = one.get("command_V")
        assert command == pytest.approx(law.step(made.seen(*told)), abs=LARGE)
        assert 0.0 <= command <= 4.0
        assert abs(command - last) <= 20.0 * 0.001 * (1.0 + 1e-9)
        last = command
    one.end()
