"""`wrist check`: a rig that did not change is as promised; a softer slope, a leak and a longer tube are seen.

The rigs are the tests' own, logged at 100 Hz with noise, under a PI at 1 kHz that sees the noise.
"""

from dataclasses import replace

import numpy as np
import pytest

from design.tuner.gains_file import write
from plants.parameters.files import built_in, dump
from plants.parameters.quantities import Fitted
from plants.parameters.remainder import BANDS, RemainderSize
from plants.wrist import Wrist
from tests.change.pairs import worn
from tests.rig.campaign import logged_table, make_rig
from tests.rig.core import Controller

GAINS = {"flexion": (4.28, 10.4), "deviation": (6.47, 18.4)}


def plant_of(rig):
    """The plant that a good trace of the rig would find, and how little it would leave."""
    plant, values, loud = built_in(rig.axis), rig.declared._asdict(), rig.noise
    fitted = {
        n: replace(p, value=values[n], provenance=Fitted("the rig's own", 0.002 * abs(values[n])))
        for n, p in plant.parameters.items()
    }
    none = dict.fromkeys(BANDS, 0.25)
    left = {
        "angle_deg": RemainderSize(0.0, 0.0, 0.01, 0.1, loud.angle_deg, 0.0, none),
        "pressure_kPa": RemainderSize(0.0, 0.0, 0.01, 0.1, loud.pressure_kPa, 0.0, none),
    }
    return replace(plant, parameters=fitted, remainder=left)


def log_of(rig, plant, path, salt=7, at=(1.0, 7.0, 12.0), to=(15.0, 0.0, -10.0), every=1):
    """A log of the task, 20 s, written as the rig's logger does, or every so many of its rows; at: moments
    [s] at which the set-point [deg] goes `to` others."""
    time = np.arange(20001) * 0.001
    asked = np.append(0.0, to)[np.searchsorted(at, time + 1e-6)]
    v = plant.values
    run = rig.follow(asked, Controller(*GAINS[rig.axis], v["gain"], v["rest_pressure"]), salt)
    logged_table(rig, "task", run, False).iloc[::every].to_csv(path, index=False)
    return path


@pytest.fixture
def designed(tmp_path):
    """A folder as `wrist design` leaves one, of a rig by motion and seed; and the rig."""

    def made(axis, seed):
        rig = make_rig(axis, [], seed)
        plant, folder = plant_of(rig), tmp_path / f"{axis}-{seed}"
        dump(plant, folder / f"plant-{axis}.toml")
        Kp, Ki = GAINS[axis]
        write(folder / f"gains-{axis}.toml", {"Kp": Kp, "Ki": Ki})
        return rig, plant, folder

    return made


@pytest.mark.slow
def test_a_rig_that_did_not_change_and_one_whose_slope_softens(wrist, designed):
    rig, plant, folder = designed("flexion", 2)
    same = wrist("check", log_of(rig, plant, folder / "log.csv"), "--design", folder, "--json", "-")
    assert same.code == 0, same.err
    assert same.json["verdict"] == "as promised"
    soft = log_of(worn(rig, "slope"), plant, folder / "soft.csv")
    found = wrist("check", soft, "--design", folder, "--out", folder / "page")
    assert found.code == 1
    assert "outside the envelope" in found.out
    assert "slopes" in found.out.splitlines()[-1]
    for name in ("check.html", "check.json", "envelope.png", "residual.png"):
        assert (folder / "page" / name).stat().st_size > 500


@pytest.mark.slow
def test_what_a_plant_is_known_to_leave_breaks_no_promise(wrist, designed):
    rig, plant, folder = designed("flexion", 2)
    quick = replace(plant.parameters["Tw"], value=0.2 * plant.parameters["Tw"].value)
    wrong = replace(plant, parameters={**plant.parameters, "Tw": quick})
    log = log_of(rig, plant, folder / "log.csv")
    dump(wrong, folder / "plant-flexion.toml")
    assert wrist("check", log, "--design", folder).code == 1  # of a plant that is said to leave nothing
    left = replace(wrong.remainder["angle_deg"], rms=1.0, largest=2.5, correlation_way=200.0)
    dump(
        replace(wrong, remainder={**wrong.remainder, "angle_deg": left}),
        folder / "plant-flexion.toml",
    )
    found = wrist("check", log, "--design", folder, "--json", "-")
    assert found.json["verdict"] == "as promised"
    assert "unchanged since the trace, to within" in found.json["words"]
    late = log_of(worn(rig, "tube", 0.15), plant, folder / "late.csv")
    assert wrist("check", late, "--design", folder, "--json", "-").json["verdict"] == "broken"


@pytest.mark.parametrize("salt", [7, 8, 9])
def test_set_points_between_the_rows_of_a_slow_log_are_no_change(wrist, designed, salt):
    rig, plant, folder = designed("flexion", 2)
    log = log_of(rig, plant, folder / "log.csv", salt, (1.001, 7.003, 12.005), (17.0, -17.0, 17.0), 2)
    found = wrist("check", log, "--design", folder, "--json", "-")
    assert found.json["verdict"] == "as promised", found.out


def test_what_cannot_be_checked_is_told_in_a_line(wrist, designed, tmp_path):
    rig, plant, folder = designed("flexion", 2)
    log = log_of(rig, plant, folder / "log.csv")
    rows = [line.rsplit(",", 1)[0] for line in log.read_text().splitlines()]
    (folder / "open.csv").write_text("\n".join(rows) + "\n")
    cases = {
        "has no reference_deg": (folder / "open.csv", "--design", folder),
        "holds no plant-MOTION.toml": (log, "--design", tmp_path),
        "--motion": (log, "--design", folder, "--motion", "yaw"),
    }
    for words, arguments in cases.items():
        outcome = wrist("check", *arguments)
        assert outcome.code == 2
        assert outcome.err.count("\n") == 1
        assert words in outcome.err


def test_a_log_with_names_of_its_own_is_to_be_imported_first(wrist, designed, tmp_path):
    """No campaign lies beside it, whose [columns] could name them."""
    rig, plant, folder = designed("flexion", 2)
    log = tmp_path / "my log.csv"
    rows = log_of(rig, plant, log).read_text()
    log.write_text(rows.replace("command_V", "u").replace("angle_deg", "theta"))
    refused = wrist("check", log, "--design", folder)
    assert refused.code == 2
    assert refused.err.count("\n") == 1
    command = f"wrist import '{log}' --axis flexion --out NEW"
    assert f"no column 'command_V'; it needs converting: {command}" in refused.err
    assert "[columns]" not in refused.err


@pytest.mark.suite
@pytest.mark.parametrize(("axis", "seed"), [("flexion", 12), ("deviation", 13), ("flexion", 14)])
def test_what_changed_is_seen_and_what_did_not_is_left_alone(wrist, designed, axis, seed):
    rig, plant, folder = designed(axis, seed)
    for salt in (7, 8):
        log = log_of(rig, plant, folder / f"same-{salt}.csv", salt)
        assert wrist("check", log, "--design", folder, "--json", "-").json["verdict"] == "as promised"
    words = {"slope": "slopes", "leak": "less pressure", "tube": "later"}
    for what, cause in words.items():
        log = log_of(worn(rig, what), plant, folder / f"{what}.csv")
        record = wrist("check", log, "--design", folder, "--json", "-").json
        assert record["residual"]["new"], what
        assert cause in record["residual"]["change"]["name"], what


def test_samples_are_asked_when_the_rig_was_not_at_the_row_after():
    from design.studies.check.envelope import _rows_of
    from plants.measured.campaigns.playback import Playback
    from plants.measured.campaigns.recording import Recording

    reference = np.array([0.0, 0.0, 15.0, 15.0])
    log = Recording("log", np.arange(4) * 0.01, np.ones(4), np.zeros(4), reference=reference)
    timed = replace(log, ahead=np.array([0.0, 0.0, 0.004, 0.0]))
    assert np.flatnonzero(np.diff(reference[_rows_of(Playback(log))])).tolist() == [19]
    assert np.flatnonzero(np.diff(reference[_rows_of(Playback(timed))])).tolist() == [15]


@pytest.mark.parametrize(("factor", "own"), [(1.0, True), (1.4, False)])
def test_a_log_that_begins_at_work_is_of_its_own_controller(designed, tmp_path, factor, own):
    """The integral part of a loop that has run for a while is not that of a wrist at rest."""
    from design.controllers.pi import PI
    from design.studies.check.check import OTHER_GAINS, _command_off
    from plants.measured.campaigns.campaign import load_recording

    rig, plant, folder = designed("flexion", 2)
    whole = load_recording(log_of(rig, plant, folder / "log.csv"), rig=plant.rig)
    at = slice(600, None)  # at 15 deg, before it goes home
    log = replace(
        whole, time=whole.time[at], command=whole.command[at], angle=whole.angle[at],
        pressure=whole.pressure[at], reference=whole.reference[at],
    )  # fmt: skip
    Kp, Ki = GAINS["flexion"]
    assert (_command_off(log, PI.of(Wrist.of(plant), factor * Kp, Ki)) <= OTHER_GAINS) == own
