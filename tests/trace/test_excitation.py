"""What sits in the command is not named as an effect of the rig."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from plants.effects.regulator.leak import LaminarLeak
from plants.effects.sensor.gyro_drift import Drift
from plants.effects.sensor.periodic import Hum
from plants.effects.wrist.creep import Creep, LogCreep, TwoTimeCreep
from plants.effects.wrist.end_stop import GivingStop, HardStop
from plants.effects.wrist.inertia import StiffeningInertia
from plants.effects.wrist.load_step import LoadStep
from plants.effects.wrist.loop_shape import OneMorePlay
from plants.measured.campaigns.playback import Playback
from plants.measured.campaigns.recording import Recording
from plants.measured.trace.ranking.contact import pressed_beyond
from plants.measured.trace.ranking.excitation import excitation, line
from plants.measured.trace.search.refits import rank

T = np.arange(6000) / 100
SINE = Recording("sine", T, 2.0 + np.sin(2 * np.pi * 0.1 * T))
STEPS = Recording("steps", T, np.repeat(np.random.default_rng(1).uniform(0, 4, 60), 100))
RAMP = Recording("ramp", T, 0.05 * T)


def asked(*recordings):
    return excitation([Playback(r) for r in recordings])


@pytest.mark.parametrize("order", [1, 2, 3, 5])
def test_a_hum_at_a_harmonic_of_the_only_sine_is_borrowed(order):
    assert f"{order} times the frequency" in Hum(0.1 * order + 0.002, 1.0).borrowed(asked(SINE))


def test_a_hum_beside_the_harmonics_is_not():
    assert Hum(0.25, 1.0).borrowed(asked(SINE)) is None


def pressed(top):
    """Steps of a joint with a lag that cannot pass an angle."""
    drive = 10.0 * STEPS.command
    angle = np.empty_like(drive)
    angle[0] = drive[0]
    for k in range(1, len(T)):
        angle[k] = min(angle[k - 1] + 0.05 * (drive[k] - angle[k - 1]), top)
    noise = np.random.default_rng(2).normal(0.0, 0.02, len(T))
    return replace(STEPS, pressure=drive, angle=angle + noise)


@pytest.mark.parametrize("form", [HardStop, GivingStop])
def test_a_stop_that_nothing_is_pressed_against_is_the_end_of_a_curve(form):
    free, stopped = pressed(1e3), pressed(25.0)
    most = float(free.angle.max())
    assert "end of a curve" in form(-90.0, most).borrowed(asked(free))
    assert form(-90.0, 25.0).borrowed(asked(stopped)) is None
    below = [replace(r, pressure=-r.pressure, angle=-r.angle) for r in (free, stopped)]
    assert "end of a curve" in form(-most, 90.0).borrowed(asked(below[0]))
    assert form(-25.0, 90.0).borrowed(asked(below[1])) is None


@pytest.mark.parametrize("hertz", [0.0, 0.8, 3.3])
def test_after_a_step_the_pressure_is_beyond_a_stop_before_the_joint_is_there(hertz):
    hum = 0.4 * np.sin(2.0 * np.pi * hertz * T)
    stopped, free = (replace(r, angle=r.angle + hum) for r in (pressed(36.0), pressed(1e3)))
    assert HardStop(-90.0, 36.0).borrowed(asked(stopped)) is None
    assert HardStop(-90.0, float(free.angle.max())).borrowed(asked(free)) is not None


def test_an_angle_that_a_joint_swings_past_is_no_stop():
    """It overshoots to its largest angle after a step, and rests there under a higher pressure."""
    drive = np.repeat([0.0, 30.0, 0.0, 40.0], 1500)
    angle = drive + np.random.default_rng(2).normal(0.0, 0.02, len(T))
    angle[1500:1540] = 40.0
    swinging = replace(STEPS, pressure=drive, angle=angle)
    assert pressed_beyond([swinging], 40.0, 1.0) < 0.01
    angle[1500:3000] = 40.0  # it stays
    assert pressed_beyond([replace(swinging, angle=angle)], 40.0, 1.0) == pytest.approx(0.25, abs=0.01)


def test_without_an_angle_nothing_is_at_a_stop():
    assert pressed_beyond([STEPS], 0.0, 1.0) == 0.0


def test_an_inertia_without_a_mass_is_none():
    assert "no mass" in StiffeningInertia(0.0, 1.5).borrowed(asked(STEPS))
    assert StiffeningInertia(0.01, 1.5).borrowed(asked(STEPS)) is None


def test_under_steps_any_hum_is_the_rigs():
    assert Hum(0.2, 1.0).borrowed(asked(STEPS, SINE, STEPS)) is None


def test_a_hum_that_does_not_come_round_twice_is_no_hum():
    assert "less than twice" in Hum(0.02, 1.0).borrowed(asked(STEPS))


def test_a_load_step_at_the_first_rows_is_an_offset():
    assert "offset" in LoadStep(1.0, 0.5).borrowed(asked(STEPS))
    assert LoadStep(1.0, 20.0).borrowed(asked(STEPS)) is None


def test_a_load_step_within_the_first_period_of_the_only_sine_is_the_commands():
    assert "offset" in LoadStep(1.0, 8.0).borrowed(asked(SINE))
    assert LoadStep(1.0, 12.0).borrowed(asked(SINE)) is None


@pytest.mark.parametrize(
    ("creep", "told"),
    [
        (Creep(0.1, 30.0), True),
        (Creep(0.1, 209.0), False),
        (TwoTimeCreep(0.05, 5.0, 0.05, 8.0), True),
        (TwoTimeCreep(0.05, 9.0, 1.0, 23.0), False),
        (LogCreep(0.1, 0.3), True),
        (LogCreep(0.1, 5.0), False),
    ],
)
def test_creep_that_is_slower_than_the_recordings_is_a_drift_in_all_of_them(creep, told):
    why = creep.borrowed(asked(STEPS))
    assert (why is None) == told
    assert told or "record for longer" in why


def test_a_form_that_is_the_commands_comes_after_one_that_is_the_rigs():
    """However much better it fits."""
    stage = SimpleNamespace(name="regulator")  # of which no loop can turn back
    models = [SimpleNamespace(chi2=x, stage=stage, wrist=SimpleNamespace(effects=(c,))) for x, c in
              ((1.0, Creep(0.1, 209.0)), (2.0, Creep(0.1, 9.0)))]  # fmt: skip
    slow, prompt = (rank(m, "creep", asked(STEPS)) for m in models)
    assert prompt < slow
    assert rank(models[0], "creep", None) < rank(models[1], "creep", None)


def test_a_drift_along_the_only_ramp_is_the_commands():
    assert "ramp" in Drift(0.01).borrowed(asked(RAMP))
    assert Drift(0.01).borrowed(asked(STEPS)) is None


def test_a_leak_along_the_only_ramp_is_the_regulators_gain():
    assert "ramp" in LaminarLeak(0.1).borrowed(asked(RAMP))
    assert LaminarLeak(0.1).borrowed(asked(SINE)) is None


def test_without_minor_loops_their_shape_is_the_branches():
    assert "few minor loops" in OneMorePlay(0.1).borrowed(asked(SINE))
    assert "few minor loops" in OneMorePlay(0.1).borrowed(asked(RAMP))
    assert OneMorePlay(0.1).borrowed(asked(STEPS)) is None


def test_other_effects_borrow_nothing():
    assert Creep(0.1, 4.0).borrowed(asked(SINE)) is None


def test_a_line_is_a_sine_or_a_wave_and_no_steps():
    triangle = Recording("triangle", T, np.abs((T / 10.0) % 2.0 - 1.0))
    assert line(triangle)[0] == pytest.approx(0.05, abs=0.005)
    assert line(STEPS) is None
    assert line(Recording("still", T, np.ones(len(T)))) is None
