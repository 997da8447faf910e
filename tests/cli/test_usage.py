"""Wrong words on the command line end in one line that says what to do; a bug in one that says it is one."""

import re

import pytest

from tests.cli.terminal import ROOT

CASES = {
    "option that is none": (["tune", "--foo"], "wrist tune: no such option --foo; see wrist tune --help"),
    "option misspelled": (["simulate", "--figur", "5"], "(did you mean --figure?)"),
    "command misspelled": (["tun"], "wrist: no such command 'tun' (did you mean tune?); see wrist --help"),
    "axis misspelled": (["tune", "--axis", "flexoin"], "(did you mean flexion?); see wrist tune --help"),
    "cost misspelled": (["tune", "--cost", "itea"], "(did you mean itae?)"),
    "memory misspelled": (["simulate", "--start", "vrigin"], "(did you mean virgin?)"),
    "controller misspelled": (["export", "feedfoward", "--out", "x"], "(did you mean feedforward?)"),
    "parameter misspelled": (["robust", "--gains", "1,2", "--box", "kfast=1:2"], "(did you mean k_fast?)"),
    "number that is none": (["simulate", "--volts", "abc"], "wrist simulate: --volts: "),
    "number out of range": (["simulate", "--duration", "0"], "wrist simulate: --duration: "),
    "argument missing": (["fit"], "wrist fit: missing argument"),
    "option missing": (["robust"], "wrist robust: missing option '--gains'"),
    "value missing": (["simulate", "--json"], "wrist simulate: option '--json' requires an argument"),
    "argument too many": (["tune", "foo"], "wrist tune: "),
}


@pytest.mark.parametrize("name", CASES)
def test_one_line_that_helps(wrist, name):
    arguments, said = CASES[name]
    outcome = wrist(*arguments)
    assert outcome.code == 2
    assert outcome.out == ""
    assert outcome.err.count("\n") == 1
    assert said in outcome.err


def test_an_effect_misspelled_in_a_file(wrist, tmp_path):
    plant = tmp_path / "plant.toml"
    text = (ROOT / "plants/parameters/flexion.toml").read_text()
    plant.write_text(f'{text}\n[effects.creeep]\nform = "x"\n')
    outcome = wrist("show", "--plant", plant)
    assert outcome.code == 2
    assert outcome.err.count("\n") == 1
    assert "(did you mean creep?)" in outcome.err


def test_alone_it_shows_its_help(wrist):
    alone, asked = wrist(), wrist("--help")
    assert alone == asked
    assert alone.code == 0
    assert "export" in alone.out


def _broken(*_: object) -> None:
    raise RuntimeError("two\nlines")


def test_a_bug_is_said_to_be_one_with_a_code_of_its_own(wrist, monkeypatch):
    monkeypatch.setattr("plants.parameters.files.built_in", _broken)
    outcome = wrist("show")
    assert outcome.code == 70
    assert outcome.err.count("\n") == 1
    assert re.search(r"bug.*RuntimeError: two lines.*--verbose", outcome.err)


def test_verbose_shows_where_the_bug_is(wrist, monkeypatch):
    monkeypatch.setattr("plants.parameters.files.built_in", _broken)
    outcome = wrist("show", "--verbose")
    assert outcome.code == 70
    assert "in _broken" in outcome.err


@pytest.mark.parametrize("command", ["show", "simulate", "tune", "export pi --gains 1,2 --out x"])
def test_a_place_that_is_none_is_told_before_the_work(wrist, tmp_path, command, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("")
    outcome = wrist(*command.split(), "--json", tmp_path / "file" / "x.json")
    assert outcome.code == 2
    assert "--json" in outcome.err
    assert outcome.out == ""
    assert [p.name for p in tmp_path.iterdir()] == ["file"]
