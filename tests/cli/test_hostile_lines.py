"""Options that cannot be meant are refused in one line: numbers that are none, names that no file can have,
options that would do nothing, two results in one place."""

import pytest

from tests.cli.terminal import ROOT

FLEXION = str(ROOT / "plants/parameters/flexion.toml")
DEVIATION = str(ROOT / "plants/parameters/deviation.toml")
RECORDING = str(ROOT / "plants/measured/examples/flexion/steps.csv")
GAINS = ("--gains", "1.2,2.2")

NUMBERS = [
    *(("tune", f"--{limit}", value) for limit in ("overshoot", "delay-margin", "variation", "steady-error")
      for value in ("inf", "nan", "1e308", "1e-320")),
    ("tune", "--ms", "inf"),
    ("tune", "--seed", "-1"),
    ("fit", "x", "--seed", "-1"),
    ("trace", "x", "--seed", "-1"),
    ("compare", "--seed", "-1"),
    ("robust", *GAINS, "--seed", "-1"),
    ("robust", "--gains", "1e308,1e308"),
    ("robust", *GAINS, "--quantum", "1e-320"),
    ("robust", *GAINS, "--noise", "1e308"),
    ("robust", *GAINS, "--load", "inf"),
    ("robust", *GAINS, "--dead-time", "nan"),
    ("robust", *GAINS, "--box", "a1=nan:1"),
    ("robust", *GAINS, "--box", "a1=0:1e308"),
    ("simulate", *GAINS, "--step", "1e308"),
    ("simulate", *GAINS, "--step", "1e5"),
    ("simulate", "--duration", "nan"),
    ("simulate", "--volts", "inf"),
    ("tune", "--corners", "nan,0,0"),
    ("tune", "--points", "9" * 30),
    ("export", "pi", "--gains", "1e308,1", "--out", "x"),
]  # fmt: skip

NAMES = [
    ("show", "--plant", "x" * 300),
    ("show", "--json", "x" * 300),
    ("show", "--plant", "a\0b"),
    ("show", "--json", "a\0b"),
    ("fit", "a\udcffb"),
    ("simulate", "--out", "a\udcffb"),
    ("tune", "--out", "y" * 300),
    ("robust", "--gains", "a\0b"),
]

IGNORED = [
    ("simulate", *GAINS, "--recording", RECORDING),
    ("simulate", *GAINS, "--volts", "2"),
    *(("simulate", "--recording", RECORDING, *given) for given in (
        ("--volts", "2"), ("--start", "line1"), ("--duration", "3"), ("--step", "5"))),
    *(("simulate", "--figure", "5", *given) for given in (
        ("--volts", "2"), ("--recording", "nowhere.csv"), ("--step", "5"), ("--start", "line1"), GAINS,
        ("--duration", "3"))),
    *(("simulate", "--scenario", "x.toml", *given) for given in (
        ("--axis", "flexion"), ("--volts", "2"), ("--start", "line1"), ("--step", "5"), ("--duration", "3"))),
    ("simulate", "--step", "5"),
    ("simulate", "--axis", "deviation", "--plant", FLEXION),
    ("show", "--axis", "flexion", "--plant", DEVIATION),
    *(("tune", simple, *given) for simple in ("--plain", "--nominal") for given in (
        ("--dead-time", "0.05"), ("--load", "1"), ("--rounds", "3"), ("--robust",), ("--two-dof",),
        ("--no-dead-time",), ("--no-load",), ("--no-noise",), ("--no-box",))),
    ("tune", "--no-dead-time", "--dead-time", "0.05"),
    ("tune", "--no-load", "--load", "1"),
    ("tune", "--scheduler", "tcp://127.0.0.1:8786"),
    ("tune", "--nominal", "--corners", "0.2,0.1,0.2"),
    ("tune", "--nominal", "--delay-margin", "0.1"),
    ("simulate", "--volts", "2", "--volts", "3"),
    ("tune", "--seed", "1", "--seed", "2"),
    ("fit", str(ROOT / "plants/measured/examples/flexion"), "--save", "same", "--json", "same"),
    ("robust", *GAINS, "--worst", "./same", "--json", "same"),
]  # fmt: skip


@pytest.mark.parametrize("line", [*NUMBERS, *NAMES, *IGNORED], ids=lambda line: " ".join(line)[-60:])
def test_it_is_refused_in_one_line(wrist, tmp_path, monkeypatch, line):
    monkeypatch.chdir(tmp_path)
    outcome = wrist(*line)
    assert outcome.code == 2, outcome
    assert outcome.out == ""
    assert outcome.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "line", [GAINS, ("--recording", RECORDING), ("--plant", FLEXION, "--axis", "flexion")]
)
def test_what_does_something_is_taken(wrist, line):
    assert wrist("simulate", *line).code == 0


def test_the_option_that_does_nothing_is_named(wrist):
    assert "--volts: with --gains" in wrist("simulate", *GAINS, "--volts", "2").err
    assert "--volts: given twice" in wrist("simulate", "--volts", "2", "--volts", "3").err
