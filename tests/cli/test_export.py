"""``wrist export`` writes a folder that checks itself, and refuses bad input before it writes anything."""

import json
import shutil
import subprocess
from types import SimpleNamespace

import pytest

from design.alternatives.designs import ROBUST_MPC
from design.cli.commands.design import _export, _exporting, _write_gains
from design.controllers.pi import PI
from design.tuner.gains_file import write
from plants.parameters.files import built_in, dump

CC = shutil.which("cc") and shutil.which("make")


@pytest.fixture
def quick(monkeypatch):
    """Vectors of few steps: their length is tested elsewhere."""
    from design.export.formats import folder

    whole = folder.contents
    monkeypatch.setattr(folder, "contents", lambda part, wrist: whole(part, wrist, 60))


def test_the_folder_and_what_is_said_of_it(wrist, tmp_path, quick):
    out = tmp_path / "c"
    told = wrist("export", "pi", "--gains", "3.1,10.4", "--axis", "deviation", "--out", out, "--json", "-")
    assert told.code == 0, told.err
    record = told.json
    assert sorted(record["files"]) == sorted(p.name for p in out.iterdir())
    assert record["name"] == "deviation_pi"
    assert record["period_s"] == 0.001
    assert record["state"][0] == {
        "name": "integral_kPa", "type": "double", "count": 1, "unit": "kPa",
        "meaning": "integral part of the command, gain included",
    }  # fmt: skip
    assert [m["name"] for m in record["measured"]] == ["reference_deg", "angle_deg"]
    assert record["output"]["unit"] == "V"
    assert (record["output"]["lowest"], record["output"]["highest"]) == (0.0, 4.0)
    assert record["settings"]["Kp"] == 3.1


@pytest.mark.slow
@pytest.mark.skipif(not CC, reason="no C compiler or make on this machine")
@pytest.mark.parametrize(
    "words",
    [["pi", "--gains", "3.1,10.4"], ["lqi", "--gains", "600,-640,-70,8,45"], ["observer"], ["mpc"]]
    + [["mpc-real-time-robust", "--gains", "25,50,2"]],
)
def test_the_folder_replays_its_vector(wrist, tmp_path, words):
    told = wrist("export", *words, "--out", tmp_path, "--json", tmp_path / "it.json")
    assert told.code == 0, told.err
    assert "make -C" in told.out.replace("\n", " ")
    said = subprocess.run(["make", "check"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert said.returncode == 0, said.stdout + said.stderr
    assert json.loads((tmp_path / "it.json").read_text())["controller"] == words[0]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["pid", "--gains", "1,2"], "no controller 'pid'"),
        (["pi"], "--gains: not given"),
        (["mpc", "--gains", "3,0.05,1.5"], "MPC delay of 1.5: give a whole number of periods"),
        (["mpc", "--gains", "3,0.05"], "--gains: 2 given; mpc takes swing"),
        (["mpc-robust", "--gains", "nowhere.toml"], "nowhere.toml"),
        (["pi", "--gains", "1,x"], "--gains: '1,x'"),
        (["pi", "--gains", "1,nan"], "--gains: '1,nan'"),
        (["pi", "--gains=-1,2"], "not negative"),
        (["pi", "--gains", "1,2,3"], "3 given"),
        (["pi", "--gains", "1,2", "--plant", "nowhere.toml"], "nowhere.toml"),
        (["plant", "--gains", "1,2"], "--gains: a plant has none"),
        (["plant", "--hand-over"], "--hand-over: a plant has none"),
        (["observer", "--hand-over"], "--hand-over: observer has none; choose pi or pi-2dof"),
        (["pi", "--gains", "1,2", "--rate-limit", "0"], "--rate-limit: 0 V/s is no rate"),
        (["plant", "--precision", "single"], "--precision: a plant is written in double"),
        (["plant", "--target", "st"], "--target st: a plant is written as c or fmu"),
    ],
)
def test_bad_input_is_refused_in_a_line_and_nothing_is_written(wrist, tmp_path, words, message):
    told = wrist("export", *words, "--out", tmp_path / "c")
    assert told.code == 2
    assert message in told.err
    assert told.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_folder_in_the_place_of_a_file_is_refused_before_anything_is_written(wrist, tmp_path, quick):
    (tmp_path / "flexion_pi_law.c").mkdir()
    told = wrist("export", "pi", "--gains", "1,2", "--out", tmp_path)
    assert told.code == 2
    assert "flexion_pi_law.c is a folder" in told.err.replace("\n", "")
    assert [p.name for p in tmp_path.iterdir()] == ["flexion_pi_law.c"]


def test_a_folder_that_cannot_be_written_to_is_refused_first(wrist, tmp_path):
    (tmp_path / "file").write_text("")
    told = wrist("export", "pi", "--gains", "1,2", "--out", tmp_path / "file")
    assert told.code == 2
    assert "--out" in told.err
    assert (tmp_path / "file").read_text() == ""


@pytest.mark.parametrize(
    ("target", "made"),
    [("fmu", {"flexion_pi_fmi2.fmu", "flexion_pi_fmi3.fmu"}), ("st", {"flexion_pi.st"})],
)
def test_another_target_is_written_with_its_vector(wrist, tmp_path, target, made):
    if target == "fmu" and not CC:
        pytest.skip("no C compiler on this machine")
    told = wrist("export", "pi", "--gains", "3.1,10.4", "--target", target, "--out", tmp_path)
    assert told.code == 0, told.err
    assert {p.name for p in tmp_path.iterdir()} == made | {"flexion_pi_vector.csv"}


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["mpc", "--target", "st"], "no function block"),
        (["observer", "--target", "fmu", "--precision", "single"], "double precision"),
    ],
)
def test_a_target_that_cannot_be_is_refused(wrist, tmp_path, words, said):
    told = wrist("export", *words, "--out", tmp_path / "x")
    assert told.code == 2
    assert said in told.err
    assert not (tmp_path / "x").exists()


def test_a_pi_that_takes_over_has_inputs_for_it(wrist, tmp_path, quick):
    words = ["export", "pi", "--gains", "3.1,10.4", "--hand-over", "--rate-limit", "20", "--out", tmp_path]
    told = wrist(*words, "--json", "-")
    assert told.code == 0, told.err
    inputs = [m["name"] for m in told.json["measured"]]
    assert inputs == ["reference_deg", "angle_deg", "manual", "manual_command_V"]
    assert told.json["settings"]["rate limit"] == 20.0


def test_an_mpc_takes_the_file_that_a_design_keeps_of_it(wrist, tmp_path, quick):
    """With the plant of the design, as the design's last line has it."""
    motion = SimpleNamespace(
        motion="flexion", gains={"Kp": 3.0, "Ki": 9.0}, plant=built_in("flexion"), holds=True,
        designs={ROBUST_MPC: {"gains": {"swing": 25.0, "move": 50.0, "delay": 2.0}, "holds": False}},
    )  # fmt: skip
    _write_gains(tmp_path, motion)
    dump(motion.plant, tmp_path / "plant-flexion.toml")
    name, *words = map(str, _exporting(tmp_path, "flexion"))
    assert name == "wrist"
    by_file = wrist(*words, "--json", "-")
    assert by_file.code == 0, by_file.err
    assert by_file.json["settings"]["delay"] == 2.0
    assert by_file.json["settings"]["weight swing"] == 25.0
    assert [f["count"] for f in by_file.json["state"] if f["name"] == "command_line_V"] == [2]
    by_number = wrist(
        "export", "mpc-real-time-robust", "--gains", "25,50,2", "--out", tmp_path / "c", "--json", "-"
    )
    assert by_number.json == by_file.json
    assert "holds = false" in (tmp_path / "mpc-flexion.toml").read_text()


@pytest.mark.parametrize("holds", [True, False])
def test_gains_that_break_a_limit_are_not_exported_as_recommended(wrist, tmp_path, quick, holds):
    """Neither by a design nor from the file of its gains."""
    motion = SimpleNamespace(
        motion="flexion", gains={"Kp": 3.0, "Ki": 9.0}, plant=built_in("flexion"), holds=holds, designs={},
        recommended="PI", controller=PI(3.0, 9.0), limits_broken=() if holds else ("settling_time_s",),
    )  # fmt: skip
    _write_gains(tmp_path, motion)
    _export(tmp_path, motion)
    gains = tmp_path / "gains-flexion.toml"
    assert wrist("export", "pi", "--gains", gains, "--out", tmp_path / "again").code == 0
    nearest = "the nearest gains: they break the limit on settling time"
    for folder in ("c-flexion", "again"):
        readme = (tmp_path / folder / "README.md").read_text().splitlines()[2]
        header = (tmp_path / folder / "flexion_pi.h").read_text().split("Made by")[0]
        assert (nearest in readme) is not holds
        assert (nearest in " ".join(header.split())) is not holds
        assert ("recommended" in readme + header) is (holds and folder == "c-flexion")


def test_gains_that_a_tuner_kept_with_a_broken_limit_are_exported_as_such(wrist, tmp_path, quick):
    path = write(tmp_path / "mine", {"Kp": 3.0, "Ki": 9.0}, {"limits_broken": ["Ms", "*/ no limit"]})
    assert wrist("export", "pi", "--gains", path, "--out", tmp_path / "c").code == 0
    title = (tmp_path / "c" / "README.md").read_text().splitlines()[2]
    assert title == "PI controller with anti-windup, with gains that break the limit on Ms."


@pytest.mark.skipif(not CC, reason="no C compiler or make on this machine")
def test_a_revised_plant_is_written_with_its_effects(wrist, tmp_path):
    from plants.effects import Creep

    own = {"creep.gain": 0.1, "creep.time_constant": 4.0}
    plant, base = tmp_path / "revised.toml", built_in("flexion")
    dump(base.revised([Creep], {**base.values, **own}, {"creep.gain": 0.001}, "p1"), plant)
    told = wrist("export", "plant", "--plant", plant, "--out", tmp_path / "c", "--json", "-")
    assert told.code == 0, told.err
    assert [m["name"] for m in told.json["given"]] == ["command_V"]
    assert [m["name"] for m in told.json["shown"]] == ["angle_deg", "pressure_kPa"]
    assert told.json["settings"]["creep.gain"] == 0.1
    said = subprocess.run(["make", "check"], cwd=tmp_path / "c", capture_output=True, text=True, check=False)
    assert said.returncode == 0, said.stdout + said.stderr
    told = wrist("export", "plant", "--plant", plant, "--out", tmp_path / "fmu", "--target", "fmu")
    assert told.code == 0, told.err
    assert sorted(p.name for p in (tmp_path / "fmu").iterdir()) == [
        "flexion_plant_fmi2.fmu", "flexion_plant_fmi3.fmu", "flexion_plant_vector.csv",
    ]  # fmt: skip


def test_a_file_with_a_second_degree_of_freedom_is_exported_with_it(wrist, tmp_path, quick):
    path = write(tmp_path / "gains", {"Kp": 1.5, "Ki": 8.1, "b": 2.0, "Tf": 0.0})
    refused = wrist("export", "pi", "--gains", path, "--out", tmp_path / "pi")
    assert refused.code == 2
    assert "has b = 2 and Tf = 0 s, which a plain PI does not; export pi-2dof with it" in refused.err
    assert not (tmp_path / "pi").exists()
    told = wrist("export", "pi-2dof", "--gains", path, "--out", tmp_path / "more", "--json", "-")
    assert told.code == 0, told.err
    assert {n: told.json["settings"][n] for n in ("Kp", "Ki", "b")} == {"Kp": 1.5, "Ki": 8.1, "b": 2.0}
    plain = write(tmp_path / "plain", {"Kp": 1.5, "Ki": 8.1})
    assert wrist("export", "pi", "--gains", plain, "--out", tmp_path / "plain_c").code == 0
