"""Strategies for lines of the command: options that cannot be meant must be refused, others may be taken."""

from typing import NamedTuple

from hypothesis import strategies as st

NOT_MEANT = ("nan", "inf", "-inf", "1e308", "-1e308", "1e-320", "1e7")
"""Values that no option's number may have."""

FLOATS = {
    "tune": (
        "--overshoot",
        "--ms",
        "--delay-margin",
        "--variation",
        "--steady-error",
        "--dead-time",
        "--load",
    ),
    "robust": ("--dead-time", "--load", "--noise", "--quantum"),
    "simulate": ("--volts", "--step", "--duration"),
}
WHOLE = {
    "tune": ("--points", "--starts", "--seed", "--rounds", "--jobs"),
    "robust": ("--samples", "--budget", "--points", "--seed", "--jobs"),
    "compare": ("--points", "--samples", "--mpc-plants", "--seed", "--jobs"),
    "fit": ("--starts", "--seed"),
    "trace": ("--seed", "--jobs"),
}
GAINS = ("a,b", "1", "1,2,3", "-1,2", "nan,1", "1,inf", "1e308,1e308", "", ",", "1;2", "1,2,", "0x1,2",
         "nowhere.toml", "../in/none.toml", "1e7,1", "١,٢٣٤,", "\x1b[2J", "1,-0.1", "NaN,NaN")  # fmt: skip


class Line(NamedTuple):
    """A line, and whether it has to be refused."""

    words: tuple[str, ...]
    must_refuse: bool


BASE = {"robust": ("--gains", "2.3,6.4"), "fit": ("nowhere",), "trace": ("nowhere",)}


@st.composite
def not_meant(draw: st.DrawFn) -> Line:
    """A line with a number, a name, an option too many: to be refused before any work."""
    kind = draw(
        st.sampled_from(["float", "whole", "twice", "gains", "box", "unknown", "ignored", "word", "same"])
    )
    if kind == "float":
        command = draw(st.sampled_from(sorted(FLOATS)))
        option = draw(st.sampled_from(FLOATS[command]))
        more = ("--gains", "1,1") if option == "--step" else ()
        words = (command, *BASE.get(command, ()), *more, f"{option}={draw(st.sampled_from(NOT_MEANT))}")
    elif kind == "whole":
        command = draw(st.sampled_from(sorted(WHOLE)))
        option = draw(st.sampled_from(WHOLE[command]))
        value = draw(st.sampled_from(("-1", "1.5", "x", "9" * 30, "", "nan", "0x10", "1e3")))
        words = (command, *BASE.get(command, ()), f"{option}={value}")
    elif kind == "twice":
        words = ("simulate", "--volts", "2", "--volts", draw(st.sampled_from(("2", "3"))))
    elif kind == "gains":
        command = draw(st.sampled_from(("simulate", "robust")))
        words = (command, f"--gains={draw(st.sampled_from(GAINS))}")
    elif kind == "box":
        box = draw(
            st.sampled_from(
                ("a1", "a1=", "a1=1", "a1=nan:1", "a1=2:1", "x=1:2", "a1=1:1e308", "=1:2", "a1=:")
            )
        )
        words = ("robust", "--gains", "2.3,6.4", f"--box={box}")
    elif kind == "unknown":
        near = draw(st.text("abcdefghijklmnopqrstuvwxyz-", min_size=1, max_size=12))
        words = (draw(st.sampled_from(("tune", "robust", "simulate", "show", "export"))), f"--zz{near}", "1")
    elif kind == "ignored":
        words = draw(st.sampled_from((
            ("simulate", "--step", "5"), ("simulate", "--gains", "1,1", "--volts", "2"),
            ("tune", "--plain", "--rounds", "3"), ("tune", "--nominal", "--dead-time", "0.01"),
            ("tune", "--plain", "--load", "1"),
            ("simulate", "--figure", "5", "--duration", "3"),
            ("tune", "--nominal", "--delay-margin", "0.1"), ("simulate", "--scenario", "x", "--volts", "1"),
            ("simulate", "--recording", "x", "--volts", "1"),
        )))  # fmt: skip
    elif kind == "same":
        place = draw(st.sampled_from(("out/a", "./out/a", "out/../out/a")))
        words = ("robust", "--gains", "2,6", "--worst", "out/a", "--json", place)
    else:
        command = draw(st.sampled_from(("tune", "compare", "show", "simulate", "robust", "tun", "")))
        words = (
            command,
            *draw(st.lists(st.text(min_size=1, max_size=20).filter(_no_option), min_size=1, max_size=2)),
        )
    return Line(words, True)


def _no_option(word: str) -> bool:
    return not word.startswith("-")


@st.composite
def quick(draw: st.DrawFn) -> Line:
    """A line of a command that is done in no time, with numbers and names of any kind."""
    number = st.one_of(
        st.floats(), st.floats(-200.0, 200.0), st.integers(-(10**20), 10**20)
    )  # fmt: skip
    name = st.one_of(
        st.text(max_size=30), st.sampled_from(("x" * 300, "a/b", "x..y", "\x1b[2J", "a\0b", "é", "a\udcff"))
    )
    words = [draw(st.sampled_from(("show", "simulate")))]
    if words[0] == "simulate":
        options = ["--volts", "--start", "--axis", "--gains", "--step"]
        for option in draw(st.lists(st.sampled_from(options), max_size=3)):
            value = {
                "--start": name,
                "--axis": name,
                "--gains": st.builds("{},{}".format, number, number),
            }.get(option, number)
            words.append(f"{option}={draw(value)}")
        words += ["--duration", draw(st.sampled_from(("0.01", "0.05", "0.123", "1")))]
    if draw(st.booleans()):
        words += ["--json", f"out/{draw(name)}"]
    return Line(tuple(words), False)
