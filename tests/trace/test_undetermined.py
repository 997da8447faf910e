"""A parameter of an effect that the recordings say nothing about is where the effect would vanish."""

import numpy as np
import pytest

from plants.effects.regulator.dead_time import DeadTime
from plants.effects.regulator.fill_exhaust import TwoRates
from plants.effects.regulator.regulator_deadband import Latch
from plants.effects.wrist.creep import Creep, TwoTimeCreep
from plants.hysteresis import PrandtlIshlinskii
from plants.measured.campaigns.playback import Playback
from plants.measured.campaigns.recording import Recording
from plants.measured.fitting.stage import Stage
from plants.measured.trace.revision.revised import at_bounds
from plants.measured.trace.search import undetermined
from plants.measured.trace.search.candidate import Candidate
from plants.measured.trace.search.undetermined import (
    at_neutral,
    in_their_middle,
    without_bends,
    without_confounded,
)
from plants.measured.trace.stages.model import Model
from plants.parameters.files import built_in
from plants.simulation.open_loop import open_loop
from plants.wrist import Wrist
from tests.laws.second_law import second_law_set

RISES = np.repeat([1.0, 2.0, 3.0, 4.0], 2000)
FALLS = np.repeat([4.0, 3.0, 2.0, 1.0], 2000)


def traced(command, tried: float, ratio: float = 0.7, every: int = 10) -> Candidate:
    """The model of a recording of a regulator that exhausts at 0.7 of the rate, or another ratio, where a
    trial has left it; every so many ms there is a row."""
    declared = built_in("flexion")
    rig = Wrist.from_values(
        {**declared.values, "fill-exhaust-asymmetry.ratio": ratio}, (TwoRates,), declared.rig
    )
    pressure = open_loop(rig, command).pressure[::every]
    noisy = pressure + np.random.default_rng(0).normal(0.0, 0.1, pressure.size)
    t = 0.001 * every * np.arange(pressure.size)
    playback = Playback(Recording("run", t, command[::every], pressure=noisy), declared.rig.sample_time)
    stage = Stage("regulator", "pressure_kPa", 0.1, (playback,), ("k_fast",), declared.rig)
    values = {**declared.values, "fill-exhaust-asymmetry.ratio": tried}
    return Candidate(Model(stage, declared, values, (TwoRates,)))


def test_a_speed_of_exhausting_that_never_shows_is_that_of_filling():
    found = at_neutral(traced(RISES, 4.1))
    assert found.model.values["fill-exhaust-asymmetry.ratio"] == 1.0


@pytest.mark.parametrize("bound", [1, 2])
def test_an_estimate_a_rounding_error_off_a_bound_is_the_bound(bound):
    model = traced(FALLS, 0.7).model
    i = model.names.index("fill-exhaust-asymmetry.ratio")
    at, inside = float(model.bounds[bound][i]), 1e-9 if bound == 1 else -1e-9
    edges = at_bounds(model.with_values({"fill-exhaust-asymmetry.ratio": at + inside}))
    assert edges[i] == at
    assert at_bounds(model) == [None] * len(model.names)


def test_one_that_shows_is_kept():
    now = traced(FALLS, 0.7)
    assert now.model.chi2 == pytest.approx(1.0, abs=0.15)
    assert at_neutral(now) is now


def test_of_a_speed_that_is_only_known_to_be_fast_enough_the_least_is_taken():
    """Rows of 5 s see of an exhaust of twice the rate, or of five times, that it is over; any value from
    there to the bound was taken, by the rounding of the machine."""
    falls = np.repeat([4.0, 3.0, 2.0, 1.0], 20_000)
    tried = [traced(falls, ratio, 4.0, 5000) for ratio in (4.9, 4.0)]
    found = [at_neutral(candidate).model for candidate in tried]
    ratios = [m.values["fill-exhaust-asymmetry.ratio"] for m in found]
    assert ratios[0] == pytest.approx(ratios[1], rel=0.05)
    assert 1.2 < ratios[0] < 2.2
    rows = found[0].residual.size
    assert all(m.chi2 < (1.0 + 1.1 / rows) * c.model.chi2 for m, c in zip(found, tried, strict=True))


def test_a_slope_of_the_curve_beyond_all_that_was_recorded_is_that_of_the_middle():
    """A trial had left it at 18 times the middle's: as a branch it made every gain unstable."""
    loop = PrandtlIshlinskii(0.08, (0.1, 0.18), 20.0, span=5.0, b2=1.0, b1=0.7, c1=0.6, c2=1.0)
    declared = second_law_set(loop)
    t = 0.01 * np.arange(3000)
    command = 2.0 + 0.7 * np.sin(0.8 * t)  # angles of +-7.4 deg, where the outer slopes begin at 8
    angle = open_loop(Wrist.of(declared), np.repeat(command, 10)).angle[:-1:10]
    noisy = angle + np.random.default_rng(0).normal(0.0, 0.05, t.size)
    assert 6.0 < np.max(np.abs(angle)) < 8.0
    playback = Playback(Recording("run", t, command, angle=noisy), declared.rig.sample_time)
    curve = ("b2", "b1", "c1", "c2")
    stage = Stage("whole", "angle_deg", 0.05, (playback,), curve, declared.rig)
    found = at_neutral(Candidate(Model(stage, declared, {**declared.values, "b2": 18.0}))).model.values
    assert {n: found[n] for n in curve} == {"b2": 1.0, "b1": 0.7, "c1": 0.6, "c2": 1.0}


def curved(swing: float, slope: float) -> Candidate:
    """A loop whose curve has a slope beyond 5 deg, fitted from another, on a command of a swing [V]."""
    loop = PrandtlIshlinskii(0.08, (0.1, 0.18), 20.0, span=5.0, b1=1.0, c1=slope)
    declared = second_law_set(loop)
    t = 0.01 * np.arange(3000)
    command = 2.0 + swing * np.sin(0.8 * t)
    angle = open_loop(Wrist.of(declared), np.repeat(command, 10)).angle[:-1:10]
    noisy = angle + np.random.default_rng(0).normal(0.0, 0.05, t.size)
    playback = Playback(Recording("run", t, command, angle=noisy), declared.rig.sample_time)
    stage = Stage(
        "whole", "angle_deg", 0.05, (playback,), ("v0", "v1", "v2", "span", "b1", "c1"), declared.rig
    )
    found = Candidate(Model(stage, declared, {**declared.values, "c1": 2.0}).fitted())
    assert found.model.chi2 == pytest.approx(1.0, abs=0.1)
    return found


def test_a_slope_that_is_only_just_met_is_that_of_the_middle_and_has_no_interval():
    now = curved(0.57, 1.0)
    assert 5.0 < np.max(np.abs(now.model.stage.target)) < 5.5
    found = without_bends(now).model
    assert (found.values["c1"], found.values["b1"]) == (1.0, 1.0)
    assert {"b1", "c1"} <= set(found.fixed)
    assert found.chi2 < 1.02 * now.model.chi2
    assert found.values["v1"] == pytest.approx(0.1, rel=0.05)


def test_a_bend_that_shows_is_kept():
    now = curved(1.2, 0.6)
    found = without_bends(now).model
    assert "c1" not in found.fixed
    assert found.values["c1"] == pytest.approx(0.6, rel=0.05)


def creeping(quick: dict[str, float], more: tuple[str, ...] = ()) -> Candidate:
    """A wrist that creeps once, slowly, fitted with a creep of two time constants that begins at `quick`;
    more: declared parameters that are fitted beside the weights of the plays."""
    declared = second_law_set(PrandtlIshlinskii(0.08, (0.1, 0.18), 20.0))
    slow = {"creep.gain": 0.1, "creep.time_constant": 4.0}
    t = 0.01 * np.arange(4000)
    levels = 2.0 + 0.7 * np.sin(0.8 * t) + 0.4 * np.sin(0.17 * t)  # nothing that the lag is told by
    rig = Wrist.from_values({**declared.values, **slow}, (Creep,), declared.rig)
    angle = open_loop(rig, np.repeat(levels, 10)).angle[:-1:10]
    noisy = angle + np.random.default_rng(0).normal(0.0, 0.05, t.size)
    playback = Playback(Recording("run", t, levels, angle=noisy), declared.rig.sample_time)
    stage = Stage("whole", "angle_deg", 0.05, (playback,), ("v0", "v1", "v2", *more), declared.rig)
    begun = {"creep.gain_late": 0.1, "creep.ratio": 20.0, **quick}
    found = Candidate(Model(stage, declared, {**declared.values, **begun}, (TwoTimeCreep,)).fitted())
    assert found.model.chi2 == pytest.approx(1.0, abs=0.1)
    return found


def test_a_creep_as_quick_as_the_lag_leaves_the_slopes_of_the_loop_determined():
    """What creeps at once and the weights are told by their product alone: with intervals of both, a design
    would be for loops of any slope."""
    now = creeping({"creep.gain": 0.2, "creep.time_constant": 0.2}, ("Tw",))
    found = without_confounded(now).model
    assert found.values["creep.gain"] == 0.0
    assert "creep.gain" in found.fixed
    for name, weight in {"v1": 0.1, "v2": 0.18}.items():
        assert found.values[name] == pytest.approx(weight, rel=0.05)
    slow = found.values["creep.time_constant"] * found.values["creep.ratio"]
    assert slow == pytest.approx(4.0, rel=0.2)


def test_a_whole_effect_is_not_set_aside_here(monkeypatch):
    """A dead time beside a lag is told from it badly by slow sines, and is for the search to judge."""
    monkeypatch.setattr(undetermined, "CONFOUNDED", 0.5)
    declared = second_law_set(PrandtlIshlinskii(0.08, (0.1, 0.18), 20.0))
    t = 0.01 * np.arange(3000)
    command = 2.0 + 0.7 * np.sin(0.8 * t)
    angle = open_loop(Wrist.of(declared), np.repeat(command, 10)).angle[:-1:10]
    noisy = angle + np.random.default_rng(0).normal(0.0, 0.05, t.size)
    playback = Playback(Recording("run", t, command, angle=noisy), declared.rig.sample_time)
    stage = Stage("whole", "angle_deg", 0.05, (playback,), ("Tw",), declared.rig)
    values = {**declared.values, "Tw": 0.14, "dead-time.delay": 0.02}
    now = Candidate(Model(stage, declared, values, (DeadTime,)).fitted())
    assert without_confounded(now) is now


def latched(steps: list[float], tried: float) -> Candidate:
    """The model of a recording of a regulator that ignores changes of 3 kPa, where a trial left it; steps:
    changes of the commanded pressure [kPa] every second, from 100 kPa."""
    declared = built_in("flexion")
    gain, width = declared.values["gain"], "regulator-deadband.width"
    command = np.repeat((100.0 + np.cumsum([0.0, *steps])) / gain, 1000)
    rig = Wrist.from_values({**declared.values, width: 3.0}, (Latch,), declared.rig)
    pressure = open_loop(rig, command).pressure[:-1:10]
    noisy = pressure + np.random.default_rng(0).normal(0.0, 0.1, pressure.size)
    t = 0.01 * np.arange(pressure.size)
    playback = Playback(Recording("run", t, command[::10], pressure=noisy), declared.rig.sample_time)
    stage = Stage("regulator", "pressure_kPa", 0.1, (playback,), ("k_fast",), declared.rig)
    return Candidate(Model(stage, declared, {**declared.values, width: tried}, (Latch,)))


@pytest.mark.parametrize("tried", [2.1, 3.0, 3.9])
def test_a_threshold_is_in_the_middle_of_what_was_ignored_and_what_was_taken_up(tried):
    """A change of 2 kPa was ignored, one of 4 was not: trials within that are all as good, and stay."""
    found = in_their_middle(latched([20.0, -2.0, 2.0, 4.0, -30.0], tried))
    assert found.model.values["regulator-deadband.width"] == pytest.approx(3.0, abs=0.05)


def test_a_threshold_stays_where_no_change_was_taken_up_that_is_near_it():
    """All that is known is that it is more than 2 kPa and less than 20."""
    now = latched([20.0, -2.0, 2.0, -30.0], 3.0)
    assert in_their_middle(now) is now


def test_a_threshold_far_from_the_true_one_is_left_to_the_fit():
    now = latched([20.0, -2.0, 2.0, 4.0, -30.0], 1.5)
    assert in_their_middle(now).model.chi2 == pytest.approx(now.model.chi2)
