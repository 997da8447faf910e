"""A fit can start from the log alone: delay, lag, gain and loop are guessed within bounds around them."""

from dataclasses import replace

import numpy as np
import pytest

from plants.errors import InputError
from plants.hysteresis import PrandtlIshlinskii
from plants.measured.campaigns.campaign import load_campaign
from plants.measured.campaigns.recording import Recording
from plants.measured.guess.output_curve import rough_curve
from plants.measured.guess.rig import guessed_rig, guessed_set
from plants.measured.guess.rough_models import first_order, largest_error, loop_guess, plays
from plants.measured.trace.rig_fit import fit_rig
from plants.parameters.files import dump, load
from plants.parameters.quantities import Guessed
from plants.rig import built_in_rig
from tests.rig.soft.named import CAMPAIGNS, bender, climber


@pytest.fixture(scope="module", params=CAMPAIGNS)
def soft(request, tmp_path_factory):
    """A rig that no parameter file describes, and its campaign."""
    make, fit, validate = CAMPAIGNS[request.param]
    rig, folder = make(), tmp_path_factory.mktemp("soft") / request.param
    rig.write(folder, fit, validate)
    return rig, load_campaign(folder)


def test_a_delayed_lag_is_found_from_steps():
    dt, tau, late = 0.01, 0.3, 20
    x = np.repeat([0.0, 1.0, 0.2, 0.8, 0.5], 300)
    delayed = np.concatenate([np.zeros(late), x])[: len(x)]
    y = np.empty(len(x))
    now = 0.0
    for i, u in enumerate(delayed):
        y[i] = now
        now += (1.0 - np.exp(-dt / tau)) * (u - now)
    found = first_order([(x, 3.0 * y + 5.0, dt)])
    assert found.gain == pytest.approx(3.0, rel=0.05)
    assert found.offset == pytest.approx(5.0, abs=0.1)
    assert found.tau == pytest.approx(tau, rel=0.3)
    assert found.delay == pytest.approx(0.2, abs=0.06)


def test_one_and_the_same_command_shows_the_lag_by_which_the_pressure_rests():
    t = np.arange(400) * 0.01
    runs = [(np.full(400, 2.0), 70.0 + start * np.exp(-t / 0.3), 0.01) for start in (-70.0, 20.0)]
    found = first_order(runs)
    assert found.gain == pytest.approx(35.0, rel=0.02)
    assert found.tau == pytest.approx(0.3, rel=0.2)


def test_plays_follow_only_when_pushed():
    x = np.array([0.0, 3.0, 2.0, -1.0])
    np.testing.assert_allclose(plays(x, np.array([1.0, 2.0])), [[0, 0], [2, 1], [2, 1], [0, 1]])


def test_the_loop_of_a_play_is_found():
    t = np.arange(6000) / 100
    x = 50.0 + 40.0 * np.sin(0.5 * t) * np.exp(-t / 60.0)
    y = 0.1 * (x - 20.0) + 0.3 * (plays(x, np.array([6.0]))[:, 0] - 20.0)
    found = loop_guess([Recording("loop", t, x, angle=y, pressure=x)], [x]).loop
    assert found.outer == pytest.approx(0.4, rel=0.05)
    assert found.width == pytest.approx(0.3 * 6.0, rel=0.15)
    assert found.rest == pytest.approx(20.0, abs=1.0)


def joint(total):
    """One that does not move at first, then does, and is half as steep in the end."""
    return np.maximum(total - 10.0, 0.0) - 0.5 * np.maximum(total - 40.0, 0.0)


def test_the_curve_of_a_joint_that_does_not_move_at_first_is_found():
    total = np.random.default_rng(3).uniform(0.0, 60.0, 3000)
    found = rough_curve(total, joint(total))
    seen = found.angle + found.about.value(found.slope * total - found.centre)
    assert np.std(seen - joint(total)) < 0.03 * 40.0
    assert found.about.b2 < 0.2
    assert found.about.c2 == pytest.approx(0.5, rel=0.1)
    assert rough_curve(total, -total) is None


def test_a_bent_loop_is_guessed_as_it_is_bent():
    """The angle of the guess where the pressure rests is 0, and along the branches it is the joint's."""
    t = np.arange(6000) / 100
    x = 50.0 - 50.0 * np.cos(0.5 * t) * np.linspace(1.0, 0.4, 6000)
    total = 0.1 * x + 0.5 * plays(x, np.array([8.0]))[:, 0]
    found = loop_guess([Recording("loop", t, x, angle=joint(total), pressure=x)], [x])
    law = PrandtlIshlinskii.from_values(PrandtlIshlinskii.guess(found.loop))
    assert float(law.curve(0.0)) == 0.0
    p = np.linspace(5.0, 95.0, 50)
    for branch, side in ((law.ascending, -1.0), (law.descending, 1.0)):
        assert np.abs(branch(p) - joint(0.6 * p + side * 0.5 * 8.0)).max() < 0.08 * joint(60.0)
    known = PrandtlIshlinskii.from_values(PrandtlIshlinskii.guess(found.loop.at_rest(30.0)))
    assert known.rest_pressure == pytest.approx(30.0)


def test_ranges_and_motion_are_those_of_the_log(soft):
    rig, campaign = soft
    found = guessed_rig(campaign)
    commands = [r.command for r in (*campaign.fit, *campaign.validate)]
    assert found.motions == (rig.name,)
    low, high = found.command_range
    assert low == pytest.approx(min(c.min() for c in commands))
    assert high == pytest.approx(max(c.max() for c in commands))
    assert found.log_time == campaign.sample_time
    rows = found.log_time / found.sample_time
    assert rows == pytest.approx(round(rows))


@pytest.mark.parametrize("law", ["four-segment", "prandtl-ishlinskii"])
def test_a_guess_is_a_set_that_says_that_it_is_guessed(soft, law, tmp_path):
    rig, campaign = soft
    found = guessed_set(campaign, law)
    assert law == found.law.NAME
    assert all(isinstance(p.provenance, Guessed) for p in found.parameters.values())
    assert all(p.low <= p.value <= p.high for p in found.parameters.values())
    assert found.values["gain"] == pytest.approx(rig.gain, rel=0.1)
    dump(found, tmp_path / "guess.toml")
    assert load(tmp_path / "guess.toml").values == found.values
    assert "guessed" in (tmp_path / "guess.toml").read_text()


@pytest.mark.parametrize(("logged", "times"), [(True, 8.0), (False, 64.0)])
def test_a_regulator_that_is_seen_through_the_angle_alone_may_be_far_faster(soft, logged, times):
    """What the joint and its creep take is in the lag of the angle."""
    _, campaign = soft
    fit = tuple(r if logged else replace(r, pressure=None) for r in campaign.fit)
    found = guessed_set(replace(campaign, fit=fit, validate=())).parameters
    for rate in (found["k_fast"], found["k_slow"]):
        assert rate.high == pytest.approx(times * rate.value)


def test_the_widest_play_is_turned_well_before_the_ends_of_strokes(soft):
    """A play of threshold r is turned by strokes of more than 2 r."""
    _, campaign = soft
    found = guessed_set(campaign, "prandtl-ishlinskii")
    low, high = found.rig.pressure_range
    assert 2.0 * found.parameters["reach"].high <= 0.91 * (high - low)


def test_the_largest_error_is_that_of_the_largest_step():
    x = np.repeat([0.0, 1.0, 0.2, 0.8, 0.5], 300)
    run = x, 40.0 * x, 0.01
    assert largest_error([run], first_order([run])) == pytest.approx(40.0, rel=0.02)


@pytest.mark.slow
def test_a_rate_that_no_recording_shows_is_not_extrapolated(tmp_path):
    """Steps of 32 kPa are fitted, steps of up to 160 kPa held out: bound by nothing, the rate far from the
    commanded pressure ended where the fit's small errors liked it, and the held-out pressure 15 kPa off."""
    climber().write(tmp_path / "climber", ("stairs", "wave"), ("check",))
    campaign = load_campaign(tmp_path / "climber")
    half_way = guessed_set(campaign).parameters["e0"]
    assert half_way.high <= 0.55 * 32.0
    found = fit_rig(campaign).declared
    assert found.validate_rmse["pressure_kPa"] <= 0.03 * 160.0


def test_a_rig_with_a_long_dead_time_is_given_longer_to_come_to_rest(soft):
    """As far as its log shows one: 20 times as long."""
    _, campaign = soft
    step = float(np.median(np.diff(campaign.fit[0].time)))
    rows = round(1.0 / step)
    late = tuple(replace(r, command=np.concatenate([r.command[rows:], np.full(rows, r.command[-1])]))
                 for r in campaign.fit)  # fmt: skip
    before, delayed = guessed_rig(campaign), guessed_rig(replace(campaign, fit=late))
    seen = first_order([(r.command, r.pressure, step) for r in late]).delay
    assert seen > 0.9
    assert delayed.task.hold == pytest.approx(max(before.task.hold, 20.0 * seen), rel=0.1)
    assert delayed.task.hold > before.task.hold


def test_a_guessed_rig_keeps_the_units_of_its_campaign(tmp_path):
    """Converter counts and a motion in mm: parameters are in them, of the loop and of the regulator."""
    bender().write(tmp_path, ("stairs",), ("check",))
    kept = (
        'command_V = {name = "command_V", unit = "counts"}\nangle_deg = {name = "angle_deg", unit = "mm"}\n'
    )
    file = tmp_path / "campaign.toml"
    file.write_text(f"{file.read_text()}[columns]\n{kept}")
    guess = guessed_set(load_campaign(tmp_path))
    assert vars(guess.rig.units) == {"command": "counts", "pressure": "kPa", "angle": "mm"}
    assert (guess.parameters["gain"].unit, guess.parameters["a1"].unit) == ("kPa/counts", "mm/kPa")
    dump(guess, tmp_path / "rig.toml")
    again = load(tmp_path / "rig.toml")
    assert again.rig.units == guess.rig.units
    assert again.values == pytest.approx(guess.values)
    assert load_campaign(tmp_path, again.rig).units == guess.rig.units
    with pytest.raises(InputError, match="stays in counts, but the command of the rig is in V"):
        load_campaign(tmp_path, built_in_rig())
