"""Channels out of step and out of zero are found where the log tells, put right, and never invented."""

from dataclasses import replace

import numpy as np
import pytest

from plants.errors import InputError
from plants.measured.campaigns.campaign import load_campaign, load_recording, parse_declaration
from plants.measured.fitting.noise import resolution
from plants.measured.instrument import offsets
from plants.measured.instrument.alignment import delay_between, in_step
from plants.measured.instrument.logger import corrected
from plants.measured.instrument.offsets import offsets_between
from plants.measured.instrument.stated import StatedHabits
from plants.measured.residual.stillness import noise_of_campaign
from plants.measured.trace.start import starting
from tests.measured.conftest import DECLARATION
from tests.rig.soft.drawn import recordings, soft_actuator
from tests.rig.soft.named import CAMPAIGNS


@pytest.fixture(scope="module")
def plain():
    return load_campaign("plants/measured/examples/flexion")


def late(recording, rows):
    """The recording with its angle logged so many rows late."""
    angle = np.concatenate([np.repeat(recording.angle[:1], rows), recording.angle[:-rows]])
    return replace(recording, angle=angle)


def written(folder, **logger):
    make, fit, validate = CAMPAIGNS["bender"]
    rig = make()
    replace(rig, logger=replace(rig.logger, **logger)).write(folder, fit, validate)
    return load_campaign(folder)


def test_a_joint_with_a_lag_is_not_late(plain):
    assert delay_between(plain) == 0.0


def test_a_late_angle_is_found_and_put_back(plain):
    rows = 15
    moved = replace(plain, fit=tuple(late(r, rows) for r in plain.fit))
    found, remarks = corrected(moved)
    (remark,) = [r for r in remarks if r.habit == "late"]
    assert remark.channel == "angle_deg"
    assert remark.value == pytest.approx(0.01 * rows, abs=0.02)
    assert not remark.stated
    for a, b in zip(found.fit, plain.fit, strict=True):
        n = len(a.time)
        left = np.sqrt(np.mean((a.angle - b.angle[:n]) ** 2))
        as_logged = np.sqrt(np.mean((late(b, rows).angle - b.angle) ** 2))
        assert left < 0.3 * as_logged + 0.1


def test_a_late_pressure_is_told_from_a_late_angle(plain):
    def moved(r, rows=15):
        return replace(r, pressure=np.concatenate([np.repeat(r.pressure[:1], rows), r.pressure[:-rows]]))

    assert delay_between(replace(plain, fit=tuple(map(moved, plain.fit)))) == pytest.approx(-0.15, abs=0.03)


@pytest.mark.slow
def test_soft_rig_with_a_late_camera(tmp_path):
    assert delay_between(written(tmp_path / "in-step")) == 0.0
    # Rows are 0.04 s apart.
    assert delay_between(written(tmp_path / "late", angle_delay=0.2)) == pytest.approx(0.2, abs=0.05)


def test_in_step_reads_a_channel_when_it_was_measured(plain):
    r = plain.fit[0]
    back = in_step(late(r, 10), "angle_deg", 0.1)
    np.testing.assert_allclose(back.angle[:-1], r.angle[: len(back.angle) - 1], atol=1e-9)
    assert len(back.time) == len(r.time) - 10


@pytest.mark.parametrize("delay", [0.013, 0.1])
def test_in_step_reads_no_finer_than_the_sensor(plain, delay):
    """Values between two rows are those that the sensor would have shown; else a guess of a rig from them has
    a resolution that no sensor has."""
    r = replace(plain.fit[0], angle=0.25 * np.rint(plain.fit[0].angle / 0.25))
    back = in_step(r, "angle_deg", delay)
    assert resolution(back.angle) == pytest.approx(0.25)
    between = np.interp(back.time + delay, r.time, r.angle)
    assert np.abs(back.angle - between).max() < 0.126


@pytest.mark.parametrize(("delay", "share"), [(0.1, 1.0), (0.105, 0.5**0.5)])
def test_between_rows_noise_is_that_of_a_mean_of_two(plain, delay, share):
    """From row to row such means differ by less than the noise of each."""
    noise = np.random.default_rng(5).normal(0.0, 0.2, len(plain.fit[0].time))
    back = in_step(replace(plain.fit[0], angle=noise), "angle_deg", delay)
    assert noise_of_campaign([back], "angle_deg") == pytest.approx(0.2 * share, rel=0.05)


def test_the_delay_of_an_angle_is_the_rigs_unless_the_logger_is_stated_to_be_late(plain):
    moved = replace(plain, fit=tuple(late(r, 15) for r in plain.fit))
    begun = starting(moved)
    assert begun.parameters.rig.angle_delay == pytest.approx(0.15, abs=0.02)
    assert "design counts this as dead time" in " ".join(map(str, begun.instrument))
    guessed = starting(replace(moved, axis="elbow"))
    assert guessed.parameters.rig.angle_delay == begun.parameters.rig.angle_delay
    stated = replace(moved, logger=replace(moved.logger, delays={"angle_deg": 0.15}))
    assert starting(stated).parameters.rig.angle_delay == 0.0
    assert "dead time" not in " ".join(map(str, starting(stated).instrument))
    before = replace(begun.parameters, rig=replace(begun.parameters.rig, angle_delay=0.05))
    assert starting(moved, before).parameters.rig.angle_delay == begun.parameters.rig.angle_delay
    assert starting(stated, before).parameters.rig.angle_delay == 0.0
    assert starting(plain, before).parameters.rig.angle_delay == 0.05  # this log tells nothing else


@pytest.mark.slow
def test_offsets_where_recordings_start_anywhere(tmp_path):
    campaign = corrected(written(tmp_path, offset=0.0))[0]
    assert offsets_between(campaign) == {}
    shifts = dict(
        zip((r.name for r in (*campaign.fit, *campaign.validate)), (6.0, -5.0, 0.0, 4.0), strict=True)
    )
    moved = replace(
        campaign,
        fit=tuple(replace(r, angle=r.angle + shifts[r.name]) for r in campaign.fit),
        validate=tuple(replace(r, angle=r.angle + shifts[r.name]) for r in campaign.validate),
    )
    found, remarks = corrected(moved)
    (remark,) = [r for r in remarks if r.habit == "offset"]
    assert remark.value == pytest.approx(6.0, abs=1.5)
    for a, b in zip((*found.fit, *found.validate), (*campaign.fit, *campaign.validate), strict=True):
        assert abs(np.mean(a.angle - b.angle)) < 1.5


@pytest.mark.slow
def test_offsets_of_two_recordings_are_read_from_their_first_rows(tmp_path):
    off, none = written(tmp_path / "off", offset=2.0), written(tmp_path / "none", offset=0.0)
    off, none = replace(off, fit=off.fit[:2]), replace(none, fit=none.fit[:2])
    # The logs have the same noise: they differ by the offsets and by rounding.
    made = {a.name: np.mean(a.angle - b.angle) for a, b in zip(off.fit, none.fit, strict=True)}
    assert np.ptp(list(made.values())) < 0.01 * np.ptp(off.fit[0].angle)
    middle = np.median(list(made.values()))
    found = offsets_between(off)
    assert {n: found[n] for n in made} == pytest.approx({n: v - middle for n, v in made.items()}, abs=0.05)
    # The held-out one begins at another pressure: it is known less well.
    (held_out,) = (np.mean(a.angle - b.angle) for a, b in zip(off.validate, none.validate, strict=True))
    assert found[off.validate[0].name] == pytest.approx(held_out - middle, abs=0.3)
    assert offsets_between(none) == {}


@pytest.mark.slow
@pytest.mark.parametrize("held_out", [False, True])
def test_one_recording_that_was_zeroed_anew_is_told_from_those_that_agree(tmp_path, held_out):
    campaign = corrected(written(tmp_path, offset=0.0))[0]
    role = "validate" if held_out else "fit"
    last = getattr(campaign, role)[-1]
    moved = replace(
        campaign, **{role: (*getattr(campaign, role)[:-1], replace(last, angle=last.angle + 5.0))}
    )
    assert offsets_between(moved)[last.name] == pytest.approx(5.0, abs=1.0)
    assert all(abs(v) < 1.0 for n, v in offsets_between(moved).items() if n != last.name)


@pytest.mark.slow
def test_a_held_out_recording_of_a_random_soft_actuator(tmp_path):
    # The two recordings that may be fitted on agree by chance, the held-out one of 301 is 0.3 deg off.
    remarks = {}
    for seed in (301, 303):
        soft_actuator(seed).write(tmp_path / str(seed), recordings(seed), ("check",))
        found = corrected(load_campaign(tmp_path / str(seed)))[1]
        remarks[seed] = [r for r in found if r.habit == "offset"]
    (remark,) = remarks[301]
    assert remark.recordings == ("check.csv",)
    assert remark.value == pytest.approx(0.304, abs=0.02)
    assert remarks[303] == []


@pytest.mark.slow
@pytest.mark.parametrize("seed", [424, 530])
def test_offsets_are_told_whatever_the_lag_of_the_joint(tmp_path, seed):
    """Actuator 530 has a lag of 0.24 s: with 0.3 s, the next that is tried, more is left than by offsets."""
    soft_actuator(seed).write(tmp_path, recordings(seed), ("check",))
    campaign = load_campaign(tmp_path)
    found = corrected(campaign)[0]
    taken = [float(np.median(a.angle - b.angle)) for a, b in zip(campaign.fit, found.fit, strict=True)]
    rig = soft_actuator(seed)
    still = replace(rig, logger=replace(rig.logger, offset=0.0))
    true = [
        float(np.median(of_rig.angle_deg.to_numpy() - zeroed.angle_deg.to_numpy()))
        for of_rig, zeroed in (
            (rig.log(rig.commands[n](), 100 + i), still.log(rig.commands[n](), 100 + i))
            for i, n in enumerate(recordings(seed))
        )
    ]
    assert np.diff(taken) == pytest.approx(np.diff(true), abs=0.06)
    assert np.ptp(taken) > 0.1


@pytest.mark.slow
@pytest.mark.parametrize("seed", [401, 422])
def test_a_small_offset_counts_by_the_standard_error_of_a_first_angle(tmp_path, seed):
    """Of 0.4 to 0.8 % of the range: less than three times the noise of a row, or two steps of the sensor."""
    rig, fit = soft_actuator(seed), recordings(seed)
    still = replace(rig, logger=replace(rig.logger, offset=0.0))
    rig.write(tmp_path / "off", fit, ("check",))
    still.write(tmp_path / "still", fit, ("check",))
    off, still = (load_campaign(tmp_path / name) for name in ("off", "still"))
    true = [
        np.mean(a.angle - b.angle)
        for a, b in zip((*off.fit, *off.validate), (*still.fit, *still.validate), strict=True)
    ]
    found = corrected(off)[0]
    taken = [
        float(np.median(a.angle - b.angle))
        for a, b in zip((*off.fit, *off.validate), (*found.fit, *found.validate), strict=True)
    ]
    assert np.diff(taken) == pytest.approx(np.diff(true), abs=0.03)
    assert not any(r.habit == "offset" for r in corrected(still)[1])


def test_a_pressure_that_never_moves_tells_no_offsets(tmp_path):
    campaign = written(tmp_path, offset=2.0)
    still = replace(campaign, fit=tuple(replace(r, pressure=np.full(len(r.time), 3.0)) for r in campaign.fit))
    assert offsets_between(still) == {}


def test_what_a_joint_remembers_until_its_first_stroke_is_no_offset(tmp_path, monkeypatch):
    campaign = written(tmp_path, offset=0.0)
    other, _, wave = campaign.fit
    stroke = (wave.pressure - wave.pressure[0]) / np.ptp(wave.pressure)
    remembered = 4.0 * (np.maximum.accumulate(stroke) < 0.49)
    assert remembered[0] == 4.0
    begun = replace(wave, angle=wave.angle + remembered).until(0.2 * wave.time[-1])
    moved = replace(campaign, fit=(begun, other))
    assert offsets_between(moved) == {}
    # Where the first stroke counts as well, it is taken for one.
    monkeypatch.setattr(offsets, "CROSSED", 0.0)
    taken = offsets_between(moved)
    assert taken[wave.name] - taken[other.name] == pytest.approx(4.0, abs=0.5)


def test_what_campaign_toml_states_is_done_and_not_looked_for(tmp_path, plain):
    stated = StatedHabits({"angle_deg": 0.05}, {"pressure_kPa": {plain.fit[0].name: 2.0}}, {})
    found, remarks = corrected(replace(plain, logger=stated))
    assert {(r.habit, r.channel, r.stated) for r in remarks} == {
        ("late", "angle_deg", True), ("offset", "pressure_kPa", True),
    }  # fmt: skip
    n = len(found.fit[0].time)
    np.testing.assert_allclose(found.fit[0].pressure, plain.fit[0].pressure[:n] - 2.0)
    np.testing.assert_allclose(found.fit[0].angle[:-1], plain.fit[0].angle[5 : n + 4], atol=1e-9)


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ("logger = 1", "logger must be a table such as "),
        ("[logger]\ndelay = 1", "unknown key 'delay' in [logger]; known are 'angle_delay_s', "),
        ("[logger]\nangle_delay_s = -0.1", "[logger] angle_delay_s -0.1 is no positive number of seconds"),
        ('[logger]\nangle_offset_deg = "a"', "[logger] angle_offset_deg: must be a number or a table"),
        (
            '[logger]\nangle_offset_deg = {"no.csv" = 1.0}',
            "[logger] angle_offset_deg: 'no.csv' is no file of this campaign; it has 'steps.csv', 'sine.csv'",
        ),
        *(
            (
                f"[logger]\nangle_range_deg = {entry}",
                "[logger] angle_range_deg must be the least and the largest",
            )
            for entry in ("1.0", "[1.0]", "[2.0, 1.0]", "[nan, 1.0]", '["a", 1.0]', "[true, 2.0]")
        ),
    ],
)
def test_a_bad_logger_table(entry, said):
    with pytest.raises(InputError) as error:
        parse_declaration(f"{DECLARATION}{entry}\n".encode(), "campaign.toml")
    assert str(error.value).startswith(f"campaign.toml: {said}")


def test_rows_written_twice_and_swapped_are_put_right(tmp_path, write_csv):
    rows = [[f"{0.01 * i:.2f}", f"{2 + 0.01 * i:.2f}", f"{i}", "100"] for i in range(60)]
    good = load_recording(write_csv("good.csv", rows))
    bad = [*rows[:10], rows[9], *rows[10:30], rows[31], rows[30], *rows[32:]]
    found = load_recording(write_csv("bad.csv", bad))
    assert found.mended == {"repeated": 1, "swapped": 1}
    np.testing.assert_array_equal(found.angle, good.angle)
    np.testing.assert_array_equal(found.time, good.time)


def test_soft_rig_whose_logger_slips(tmp_path):
    good, slipped = written(tmp_path / "good"), written(tmp_path / "slipped", slips=6)
    for a, b in zip((*slipped.fit, *slipped.validate), (*good.fit, *good.validate), strict=True):
        assert a.mended == {"repeated": 6, "swapped": 6}
        np.testing.assert_array_equal(a.angle, b.angle)
    said = [str(r) for r in corrected(slipped)[1]]
    assert "24 rows were written twice (4 recordings); the copies are left out." in said
    assert "24 rows stood in the wrong order (4 recordings); they are put in order." in said
