"""On a terminal there are progress bars, colours and tables that fit; in pipes there are none of these."""

import json

import pytest

from tests.cli.terminal import ROOT, on_terminal, piped

QUICK = ("tune", "--plain", "--points", "8", "--starts", "1")
FIT = ("fit", ROOT / "plants/measured/examples/flexion", "--starts", "1")
ESCAPE, BAR = "\x1b", "━"


@pytest.mark.slow
def test_a_bar_on_the_terminal_leaves_no_trace_in_stdout(tmp_path):
    seen = on_terminal(*QUICK, "--json", "-", stdout=tmp_path / "out.json")
    assert seen.code == 0, seen.screen
    assert BAR in seen.screen
    assert "tune: map" in seen.screen
    assert json.loads(seen.out)["Kp"] > 0.0


@pytest.mark.slow
def test_no_bar_and_no_colour_in_a_pipe():
    outcome = piped(*QUICK)
    assert outcome.stderr == ""
    assert ESCAPE not in outcome.stdout
    assert outcome.stdout.startswith("Kp = ")


@pytest.mark.slow
def test_a_dumb_terminal_gets_plain_text():
    seen = on_terminal(*QUICK, TERM="dumb")
    assert seen.code == 0
    assert ESCAPE not in seen.screen
    assert BAR not in seen.screen


@pytest.mark.parametrize(("more", "coloured"), [({}, True), ({"NO_COLOR": "1"}, False)])
def test_colours_unless_they_are_not_wanted(more, coloured):
    screen = on_terminal("show", **more).screen
    assert ("\x1b[33m" in screen or "\x1b[1;33m" in screen) is coloured


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "columns"),
    [
        *((("show",), columns) for columns in (60, 80, 120)),
        (FIT, 60),
        *(pytest.param(FIT, columns, marks=pytest.mark.suite) for columns in (80, 120)),
    ],
)
def test_nothing_is_wider_than_the_terminal_or_cut(arguments, columns):
    seen = on_terminal(*arguments, columns=columns, NO_COLOR="1", TERM="dumb")
    assert seen.code == 0
    to_copy = "next: "  # a command, which the terminal itself wraps
    assert max(len(line) for line in seen.lines if not line.startswith(to_copy)) <= columns
    assert "…" not in seen.screen


def test_tables_in_a_pipe_are_as_wide_as_they_are():
    lines = piped("show", "--axis", "deviation").stdout.splitlines()
    assert max(map(len, lines)) > 80
    assert sum("within" in line for line in lines) == 11  # one line a parameter, none broken
