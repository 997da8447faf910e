"""A file of gains is taken wherever gains are given, and a bad one is refused in one line."""

import json
from dataclasses import replace

import pytest

from design.cli import main
from design.cli.commands.compare import robust
from design.cli.commands.robust import controller
from design.tuner.gains_file import read, read_mpc, write, write_mpc
from plants import Wrist
from plants.errors import InputError
from plants.rig import Units, built_in_rig

GAINS = {"Kp": 2.345678901234567, "Ki": 6.1}


@pytest.fixture
def kept(tmp_path):
    return write(
        tmp_path / "mine.toml", GAINS, {"plant": "flexion", "dead_time": 0.02, "limits_broken": ["Ms"]}
    )


def test_it_comes_back_to_the_last_bit(kept):
    assert read(kept) == tuple(GAINS.values())


def test_it_is_in_the_units_of_the_rig(tmp_path):
    of_mm = replace(built_in_rig(), units=Units("V", "bar", "mm"))
    path = write(tmp_path / "bend.toml", GAINS, rig=of_mm)
    assert 'unit = "bar/(mm s)"' in path.read_text()
    assert read(path, of_mm) == tuple(GAINS.values())
    with pytest.raises(InputError, match="unit 'bar/mm' is wrong; give it in kPa/deg"):
        read(path)


OF_MPC = {"swing": 25.1, "move": 50.0, "delay": 2.0}


def test_that_of_an_mpc_too_comes_back_in_the_units_of_the_rig_and_replaces_the_one_before(tmp_path):
    path = write_mpc(tmp_path / "mpc-bend.toml", {**OF_MPC, "swing": 1.0})
    of_mm = replace(built_in_rig(), units=Units("A", "bar", "mm"))
    assert write_mpc(path, OF_MPC, {"holds": True}, of_mm) == path
    assert 'unit = "1/mm^2"' in path.read_text()
    assert read_mpc(path, of_mm) == tuple(OF_MPC.values())
    with pytest.raises(InputError, match=r"unit '1/mm\^2' is wrong; give it in 1/deg\^2"):
        read_mpc(path)


def test_the_gains_of_a_pi_are_none_of_an_mpc_and_the_other_way_round(kept, tmp_path):
    with pytest.raises(
        InputError, match=r"holds no \[gains.swing\] and \[gains.delay\]; give a file that `wr"
    ):
        read_mpc(kept)
    with pytest.raises(InputError, match=r"holds no \[gains.Kp\] and \[gains.Ki\]"):
        read(write_mpc(tmp_path / "mpc.toml", OF_MPC))


def wrist(capsys, *arguments):
    code = 0
    try:
        main([str(a) for a in arguments])
    except SystemExit as stop:
        code = int(stop.code or 0)
    said = capsys.readouterr()
    assert code == 0, said.err
    return said.out


@pytest.mark.slow
def test_commands_take_it_as_they_take_the_numbers(capsys, kept, tmp_path):
    given = f"{GAINS['Kp']},{GAINS['Ki']}"
    by_file, by_number = (
        json.loads(wrist(capsys, "simulate", "--gains", g, "--json", "-")) for g in (kept, given)
    )
    assert by_file == by_number
    for folder, g in (("file", kept), ("number", given)):
        wrist(capsys, "export", "pi", "--gains", g, "--out", tmp_path / folder)
    ours, theirs = ({p.name: p.read_text() for p in (tmp_path / of).iterdir()} for of in ("file", "number"))
    said = ", with gains that break the limit on Ms"  # the file tells, numbers cannot
    titled = {name for name, text in ours.items() if said in text}
    assert {"README.md", "flexion_pi.h"} <= titled
    differ = {name for name in ours if ours[name].replace(said, "") != theirs[name]}
    assert differ <= {"MANIFEST.sha256", "SHA256SUMS", "manifest.sha256"}
    assert ours["flexion_pi.c"] == theirs["flexion_pi.c"]
    flexion = Wrist.flexion()
    assert controller(str(kept), flexion) == controller(given, flexion)
    assert robust([f"flexion={kept}"], {"flexion": flexion}) == robust([given], {"flexion": flexion})


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (None, "no such file"),
        ("Kp = = 2", "not valid TOML"),
        ("Kp = 2.0\nKi = 3.0", r"holds no \[gains.Kp\]"),
        ('[gains]\nKp = 2.0\nKi = {value = 3.0, unit = "kPa/(deg s)"}', "gains.Kp: value None"),
        (
            '[gains]\nKp = {value = 2.0, unit = "V/deg"}\nKi = {value = 3.0, unit = "kPa/(deg s)"}',
            "give it in kPa/deg",
        ),
        ('[gains]\nKp = {value = -2.0, unit = "kPa/deg"}\nKi = {value = 3.0, unit = "kPa/(deg s)"}', "-2.0"),
        ('[gains]\nKp = {value = inf, unit = "kPa/deg"}\nKi = {value = 3.0, unit = "kPa/(deg s)"}', "inf"),
    ],
)
def test_a_bad_file_is_refused_in_one_line(tmp_path, text, words):
    path = tmp_path / "bad.toml"
    if text is not None:
        path.write_text(text)
    with pytest.raises(InputError, match=words) as refused:
        read(path)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("name", ["", "  ", ".toml", "a\0b"])
def test_a_name_that_is_none_is_refused(name):
    with pytest.raises(InputError, match=r"is no name of a file; give one such as gains\.toml"):
        write(name, GAINS)


def test_nothing_is_written_over_another_file_or_into_one(tmp_path, kept):
    before = kept.read_text()
    with pytest.raises(InputError, match="exists already; choose another name"):
        write(kept, GAINS)
    with pytest.raises(InputError, match="cannot be written"):
        write(kept / "in-a-file.toml", GAINS)
    assert kept.read_text() == before
    assert write(kept, {"Kp": 1.0, "Ki": 1.0}, mine=[kept]) == kept
    assert [p.name for p in tmp_path.iterdir()] == ["mine.toml"]


def test_the_ending_is_added(tmp_path):
    assert write(tmp_path / "mine", GAINS).name == "mine.toml"
