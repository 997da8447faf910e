"""A stage begins each recording at its first rows, as a held-out one begins, and leaves out enough blocks of
it, however short the recordings are."""

from dataclasses import replace

import numpy as np
import pytest

from plants.effects import Coupling, Creep, QuadraticCoupling
from plants.measured.campaigns.begin import Begin, first_begin, like_fitted, same_places, without_shift
from plants.measured.campaigns.campaign import load_campaign
from plants.measured.campaigns.playback import Playback
from plants.measured.campaigns.recording import Recording
from plants.measured.fitting import determined
from plants.measured.fitting.blocks import LEAST_BLOCKS, blocks
from plants.measured.fitting.fit import fit_campaign
from plants.measured.fitting.problem import FitProblem
from plants.measured.fitting.stage import Stage, begun
from plants.measured.trace.declared import stages_of
from plants.measured.trace.start import starting
from plants.parameters.files import built_in
from plants.rig import Units, Zero, built_in_rig
from plants.simulation.open_loop import open_loop
from plants.wrist import Wrist
from tests.laws.second_law import LOOP
from tests.rig.soft.commands import stairs
from tests.rig.soft.named import CAMPAIGNS, bender


@pytest.fixture(scope="module")
def stages(tmp_path_factory):
    make, fit, validate = CAMPAIGNS["bender"]
    folder = tmp_path_factory.mktemp("soft") / "bender"
    make().write(folder, fit, validate)
    begun = starting(load_campaign(folder))
    return stages_of(begun.campaign, fit_campaign(begun.campaign, begun.parameters, begun.starts, 0))


def test_a_recording_begins_at_what_its_first_rows_show(stages):
    for stage in stages:
        for playback, begin in zip(stage.playbacks, stage.begins, strict=True):
            assert begin.pressure == pytest.approx(np.median(playback.recording.pressure[:3]))
            assert begin.angle == pytest.approx(np.median(playback.recording.angle[:3]))


def test_a_held_out_recording_is_virgin_where_those_are_that_start_there():
    """The rest pressure of a law that has one more zone without a slope says little of where it rests."""
    t = np.arange(10) * 0.1
    log = Recording("check", t, 0.0 * t, pressure=0.0 * t + 3.0, angle=0.0 * t)
    there, elsewhere = Begin(3.2, 0.1, True), Begin(40.0, 0.1, True)
    rig = built_in_rig()
    assert not first_begin(log, 10.0, rig).virgin
    assert like_fitted(log, 10.0, rig, (there, elsewhere)) == Begin(3.0, 0.0, True)
    assert like_fitted(log, 10.0, rig, (elsewhere,)) == first_begin(log, 10.0, rig)
    assert not like_fitted(log, 3.0, rig, (replace(there, virgin=False),)).virgin


def test_the_virgin_curve_begins_where_a_rig_rests_that_is_counted_from_mid_range():
    """Four segments have no such curve but from 0: they begin between their branches."""
    t = np.arange(10) * 0.1
    log = Recording("check", t, 0.0 * t, pressure=0.0 * t + 3.0, angle=0.0 * t - 15.9)
    rig = replace(built_in_rig(), zero=Zero(angle=16.0, rest=-16.0))
    begin = first_begin(log, 36.0, rig)
    assert begin == Begin(3.0, -15.9, True, -16.0)
    assert not begin.at_zero
    assert not first_begin(replace(log, angle=0.0 * t), 36.0, rig).virgin
    at = begin.state(LOOP)
    assert float(at.memory.h) == -16.0
    assert np.ptp(at.memory.plays) == 0.0  # none has been moved to an end of its gap
    four = built_in("flexion").law.from_values(built_in("flexion").values)
    assert begin.state(four) == replace(begin, virgin=False).state(four)
    assert replace(begin, rest=0.0).state(four).memory == four.initial()


def test_recordings_that_start_at_the_same_place_rested_alike():
    begins = [Begin(p, 0.0, virgin=False) for p in (3.0, 40.0, 4.0, 42.0, 6.0)]
    assert same_places(begins, built_in_rig()) == ((0, 2, 4), (1, 3))


def test_whether_they_rested_is_decided_by_all_of_a_place_together(monkeypatch):
    """By itself the second would be off the virgin curve, the others on it; what is elsewhere is another
    question."""
    left = {True: (80.0, 104.0, 96.0, 30.0), False: (100.0, 100.0, 100.0, 20.0)}
    monkeypatch.setattr(determined, "_sizes", lambda problem, x: list(left[problem.stage.begins[0].virgin]))
    begins = tuple(Begin(p, 0.0, virgin=False) for p in (3.0, 4.0, 6.0, 60.0))
    stage = Stage("wrist", "angle_deg", 1.0, (), (), built_in_rig(), begins=begins)
    found = determined.remembered(FitProblem(stage, (), (), {}), np.zeros(0))
    assert [b.virgin for b in found] == [True, True, True, False]


@pytest.mark.parametrize(("off", "stays"), [(91.0, True), (89.0, False)])
def test_what_rests_is_off_the_virgin_curve_only_where_it_fits_a_tenth_better(monkeypatch, off, stays):
    """Where the loop is flat its memory hangs on hundredths of an angle, and fits a little better with it."""
    left = {True: (100.0,), False: (off,)}
    monkeypatch.setattr(determined, "_sizes", lambda problem, x: list(left[problem.stage.begins[0].virgin]))
    stage = Stage("wrist", "angle_deg", 1.0, (), (), built_in_rig(), begins=(Begin(3.0, 0.0, virgin=True),))
    (found,) = determined.remembered(FitProblem(stage, (), (), {}), np.zeros(0))
    assert found.virgin == stays


@pytest.mark.parametrize(("pressure", "rests"), [(1.02, True), (1.2, False)])
def test_a_rest_is_as_near_as_the_units_of_the_rig_make_it(pressure, rests):
    """0.2 bar are 20 kPa, a tenth of the range of the rig."""
    rig = replace(built_in_rig(), units=Units("V", "bar", "deg"), pressure_range=(0.0, 2.0))
    t = np.arange(10) * 0.1
    log = Recording("log", t, 0.0 * t, pressure=0.0 * t + pressure, angle=0.0 * t)
    assert first_begin(log, 1.0, rig).virgin == rests
    others = (Begin(1.03, 0.0, True), Begin(1.5, 0.0, False))
    assert like_fitted(log, 0.0, rig, others).virgin == rests


def test_a_short_recording_makes_blocks_enough_for_every_fold(tmp_path):
    asked = dict.fromkeys(("short", "check"), lambda: stairs([0, 2000, 1000], 8.0))
    replace(bender(), commands=asked).write(tmp_path / "short", ("short",), ("check",))
    begun = starting(load_campaign(tmp_path / "short"))
    (played,) = (Playback(r, begun.parameters.rig.sample_time) for r in begun.campaign.fit)
    stage = Stage("regulator", "pressure_kPa", 1.0, (played,), (), begun.parameters.rig)
    assert len(np.unique(stage.left_out_blocks)) >= LEAST_BLOCKS


@pytest.mark.parametrize(("rows", "many"), [(601, 6), (640, 6), (655, 7), (30, 1)])
def test_what_is_left_at_the_end_is_a_block_only_from_half_a_block_on(rows, many):
    assert len(np.unique(blocks([0.1 * np.arange(rows)], 10.0, least=0.5))) == many


@pytest.mark.parametrize("effects", [(Coupling(-0.03),), (QuadraticCoupling(0.02, 1.5), Creep(0.1, 2.0))])
def test_a_rest_that_the_other_motion_moves_is_the_rest_of_the_virgin_curve(effects):
    """It shifted the angle by 2 deg, which the loop had been begun at besides: it went twice as far."""
    wrist = sum(effects, start=Wrist.flexion())
    command, other = np.repeat([2.0243, 1.5, 3.0, 2.2], 1500), np.full(6000, 165.0)
    went = open_loop(wrist, command, other_pressure=other)
    t = 0.01 * np.arange(600)
    log = Recording(
        "log", t, command[::10], pressure=went.pressure[:-1:10], angle=went.angle[:-1:10],
        other_pressure=other[::10],
    )  # fmt: skip
    begin = first_begin(log, float(wrist.hysteresis.rest_pressure), wrist.rig)
    assert abs(begin.angle) > 1.5
    assert begin.other == pytest.approx(65.0)
    _, angle = Playback(log, 0.001).play(wrist, begun(wrist, begin))
    np.testing.assert_allclose(angle, log.angle, atol=0.02)


def test_a_start_between_the_branches_is_that_of_the_loop_without_the_other_motion():
    """At 150 kPa and 16 deg, 2 of them of the other motion."""
    wrist = Wrist.flexion() + Coupling(-0.03)
    begin = Begin(150.0, 14.0, virgin=False, other=2.0 / 0.03)
    at = begun(wrist, begin)
    assert float(at.memory.h) == pytest.approx(16.0)
    assert float(at.angle) == pytest.approx(14.0)


def test_a_start_near_rest_stays_between_the_branches_where_a_fit_had_it_there():
    """The noise of the other motion's pressure is no reason to put it on the virgin curve."""
    wrist = Wrist.flexion() + Coupling(-0.03)
    begin = Begin(100.5, 0.3, virgin=False, other=0.2)
    assert without_shift(begin, -0.006, 100.0, wrist.rig) == replace(begin, angle=0.306)
    away = Begin(100.5, -1.9, virgin=False, other=65.0)
    assert without_shift(away, -1.95, 100.0, wrist.rig).virgin
