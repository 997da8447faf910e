"""What a test vector is made of: references of every kind, a sensor's noise and steps, readings that are lost
or that no plant can have made."""

import numpy as np
import pytest

from design.export.catalogue import part
from design.export.vectors import (
    LOST,
    NOISE_DEG,
    NUDGE,
    SPIKES,
    TargetReplay,
    _open_loop,
    apart,
    by_hand,
    csv,
    references,
    spoiled,
    vector,
)
from design.mpc.observer import begin
from design.mpc.prediction import coefficients, roll, start_of
from design.mpc.problem import nominal
from plants.errors import InputError
from tests.control.c_target import WRIST

PI = part("pi", "flexion", WRIST, (3.1, 10.4))


@pytest.fixture(scope="module")
def made():
    return vector(PI, WRIST, 2000)


def test_references_are_jumps_a_chirp_ramps_and_jumps_again():
    draw = np.random.default_rng(0)
    found = references(8000, 0.001, (80.0, -60.0), draw)
    t = np.arange(8000) * 0.001
    levels = found[:2000:400]
    assert np.array_equal(np.repeat(levels, 400), found[:2000])  # each held for 0.4 s
    assert levels[2:4].tolist() == [80.0, -60.0]
    assert (np.abs(levels[[0, 1, 4]]) <= 25.0).all()
    phase = 2.0 * np.pi * (0.2 * t + 0.15 * t**2)
    np.testing.assert_allclose(found[2000:4000], 12.0 * np.sin(phase[2000:4000]), atol=1e-9)
    ramps = found[4000:6000]
    assert (ramps.max(), ramps.min()) == pytest.approx((10.0, -10.0), abs=0.02)
    assert np.abs(np.diff(ramps)) == pytest.approx(0.01, abs=1e-9)  # 10 deg/s, up and down
    assert len(np.unique(found[6000:])) == 5
    slow = references(400, 0.02, (80.0, -60.0), np.random.default_rng(0))
    assert np.flatnonzero(np.diff(slow[:100]))[0] == 59  # held for 60 samples at least


def test_what_is_out_of_reach_is_nine_tenths_of_the_widest_reference_that_is_believed(monkeypatch):
    asked = []

    def noted(steps, period, far, draw):
        asked.append((steps, period, far))
        return references(steps, period, far, draw)

    monkeypatch.setattr("design.export.vectors.references", noted)
    vector(PI, WRIST, 60)
    widest = PI.sensors.angle
    assert asked == [(60, PI.period, pytest.approx((0.9 * widest.high, 0.9 * widest.low)))]
    assert asked[0][2][0] > WRIST.hysteresis.ascending(4.0 * WRIST.regulator.gain)  # what 4 V come to


def test_readings_are_lost_and_spoiled_as_often_as_it_says(made):
    assert LOST == 12
    assert len(set(SPIKES)) == 6
    assert np.count_nonzero(np.isnan(made.rows[:, :3])) in (11, 12)  # one may be spoiled as well
    places = spoiled(PI, 2000, np.random.default_rng(1))
    assert len(places) == 12
    assert min(places) >= 1
    told = [(value, added) for _, value, added in places.values()]
    assert [v for v, added in told if added == 0.0] == list(SPIKES)
    sensors = PI.sensors
    for place, value, added in places.values():
        assert place in (0, 1, 2)
        if added:
            channel = {1: sensors.angle, 2: sensors.pressure}[place]
            assert added == 1.0
            assert value == pytest.approx(0.3 * (channel.high - channel.low))  # a jump within the range
    for value in SPIKES:
        assert value in made.rows[:, :3]
    drawn = [spoiled(PI, 2000, np.random.default_rng(seed)) for seed in range(20)]
    each = {(place, added > 0.0) for found in drawn for place, _, added in found.values()}
    assert each == {(0, False), (1, False), (2, False), (1, True), (2, True)}  # a reference may jump


def test_no_sample_is_lost_twice(monkeypatch):
    """So that of as few samples as 20 as many are lost, one value each."""
    monkeypatch.setattr("design.export.vectors.spoiled", lambda *given: {})
    lost = np.isnan(vector(PI, WRIST, 20).rows[:, :3]).sum(axis=1)
    assert sorted(lost) == [0] * (20 - LOST) + [1] * LOST


def test_by_hand_commands_lie_in_the_range_and_a_fifth_beyond_and_are_lost_now_and_then():
    handed = part("pi", "flexion", WRIST, (3.1, 10.4), by_hand=True)
    turns, told = np.array(by_hand(handed, 8000, np.random.default_rng(2))).T
    assert np.count_nonzero(np.isnan(turns)) == 20
    assert np.count_nonzero(np.isnan(told)) == 80
    assert set(turns[np.isfinite(turns)]) == {0.0, 1.0}
    for values, held in ((turns, 60), (told, 40)):
        of = np.append(values, np.full(-len(values) % held, np.nan)).reshape(-1, held)
        assert np.nanmax(np.nanmax(of, axis=1) - np.nanmin(of, axis=1)) == 0.0
    known = told[np.isfinite(told)]
    assert -0.8 <= known.min() < -0.6  # of a range from 0 to 4 V
    assert 4.6 < known.max() <= 4.8
    assert by_hand(PI, 3, np.random.default_rng(2)) == [[], [], []]


@pytest.mark.parametrize("start", ["line1", "line2"])
def test_a_law_with_a_delay_begins_with_the_line_full_of_where_it_rests(start):
    """Held at its reference it goes on with the command that it began with."""
    law = TargetReplay(part("feedforward-pi", "flexion", WRIST, (1.2, 2.2, 0.0305)))
    rest = WRIST.rest(start, 9.0)
    pressure, angle = float(rest.pressure), float(rest.angle)
    begun = law.begin(pressure, angle)
    assert begun == pytest.approx(pressure / WRIST.regulator.gain)
    sent = [law.step(law.part.seen(angle, angle, pressure)) for _ in range(60)]
    np.testing.assert_allclose(sent, begun, atol=1e-9)


def test_the_angle_comes_in_steps_and_with_noise(made):
    angle = made.rows[:, 1]
    with np.errstate(invalid="ignore"):
        shown = np.isfinite(angle) & (np.abs(angle) < 60.0)
    steps = np.round(angle[shown] * 100.0).astype(int)
    np.testing.assert_allclose(angle[shown] * 100.0, steps, atol=1e-6)
    assert np.gcd.reduce(steps) == 1  # and not in wider ones
    third = np.diff(angle[shown], 3)
    third = np.sort(np.abs(third))[: int(0.9 * third.size)]
    assert np.sqrt(np.mean(third**2) / 20.0) == pytest.approx(
        0.07 * 0.79, rel=0.1
    )  # of normal noise, trimmed
    pressure = made.rows[:, 2]
    with np.errstate(invalid="ignore"):
        pressure = pressure[np.isfinite(pressure) & (np.abs(pressure) < 200.0)]
    moved = np.abs(np.diff(pressure, 3))
    assert np.median(moved) / 0.6745 / np.sqrt(20.0) == pytest.approx(0.2, rel=0.15)
    assert (made.pressure, made.angle) == (pytest.approx(100.0), pytest.approx(0.0))


def test_the_middle_of_the_loop_stands_at_the_reference():
    p = WRIST.hysteresis
    for reference in (-10.0, 0.0, 8.0):
        pressure = WRIST.regulator.gain * _open_loop(WRIST, reference)
        lines = [p.a1 * (pressure - p.rest_pressure), p.a2 * (pressure - p.rest_pressure)]
        assert np.mean(lines) == pytest.approx(reference, abs=1e-9)
    assert _open_loop(WRIST, 1e3) == 4.0
    assert _open_loop(WRIST, -1e3) == 0.0


def test_the_table_has_what_the_law_reads_and_what_it_answered(made):
    head, *lines = csv(PI, made).splitlines()
    assert head == "reference_deg,angle_deg,expected_command_V"
    read = np.array([[float(x) for x in line.split(",")] for line in lines])
    np.testing.assert_array_equal(read, made.rows[:, [0, 1, 3]])


@pytest.mark.parametrize(("kind", "gains", "words"), [
    ("pi", (0.0, 0.0), "controls nothing"),
    ("pi-2dof", (0.0, 0.0, 0.7, 0.01), "controls nothing"),
    ("pi", None, r"not given; pi takes Kp"),
    ("pi", (1.0,), r"1 given; pi takes"),
    ("mpc", (1.0,), r"1 given; mpc takes swing"),
    ("feedforward-pi", (1.2, 2.2, 1e3), "longer than"),
])  # fmt: skip
def test_what_cannot_be_is_refused(kind, gains, words):
    with pytest.raises(InputError, match=words):
        part(kind, "flexion", WRIST, gains)
    assert part("pi", "flexion", WRIST, (0.0, 1.0)).name == "flexion_pi"


def test_a_dead_time_stands_between_the_law_that_knows_of_it_and_the_wrist():
    """A wrist that is given the expected commands two periods late shows what was measured."""
    late = part("mpc-robust", "flexion", WRIST, (100.0, 100.0, 2.0))
    found = vector(late, WRIST, 100)
    commands = [found.pressure / WRIST.regulator.gain] * 2 + found.rows[:, 3].tolist()
    problem = nominal(WRIST)
    start = start_of(begin(found.angle, found.pressure, WRIST))
    states = roll(problem, coefficients(WRIST), start, 0.0, np.array(commands[:99]))
    off = np.abs(states[:, -1] - found.rows[1:, 1])
    assert np.nanmedian(off) < 2.0 * NOISE_DEG
    wrong = roll(problem, coefficients(WRIST), start, 0.0, np.array(commands[2:]))[:99]
    assert np.nanmedian(np.abs(wrong[:, -1] - found.rows[1:, 1])) > np.nanmedian(off)


def test_how_far_an_output_comes_to_be_off_is_told_of_a_nudge_of_the_first_angle_alone(monkeypatch, made):
    nudges = []

    class Amplifying:
        """Answers as the vector has it, and with a thousandfold of what the first angle is off."""

        def __init__(self, part):
            self.rows = iter(made.rows.tolist())

        def begin(self, pressure, angle):
            assert (pressure, angle) == (made.pressure, made.angle)

        def step(self, seen):
            reference, angle, pressure, output = next(self.rows)
            np.testing.assert_array_equal(seen[::2], [reference, pressure])
            nudges.append(seen[1] - angle)
            return output + 1e3 * nudges[0]

    monkeypatch.setattr("design.export.vectors.TargetReplay", Amplifying)
    assert apart(PI, made) == pytest.approx(1e3 * NUDGE, rel=1e-6)
    assert len(nudges) == len(made.rows)
    assert not np.nan_to_num(nudges[1:]).any()


@pytest.mark.slow
def test_a_law_that_its_dead_time_makes_unstable_by_itself_is_refused():
    bold, mild = (part("mpc", "flexion", WRIST, (3.0, move, 2.0)) for move in (0.05, 5.0))
    with pytest.raises(InputError, match="unstable by itself behind the dead time of its model") as refused:
        vector(bold, WRIST, 1000)
    assert "\n" not in str(refused.value)
    assert 0.0 < apart(mild, vector(mild, WRIST, 1000)) < 1e-9
