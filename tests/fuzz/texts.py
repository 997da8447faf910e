"""Strategies for texts that were spoiled: TOML, tables, numbers, names."""

import re
from pathlib import Path
from typing import NamedTuple

from hypothesis import strategies as st

NONE = ("nan", "inf", "-inf", "+nan")
HUGE = ("1e308", "-1e308", "1e-320", "1" * 400, "9" * 30, "0x7fffffffffffffffffff")
ODD = (
    '""',
    '"text"',
    "true",
    "[]",
    "{}",
    "[[1]]",
    "1979-05-27",
    "0",
    "-1",
    "1e9",
    "-0.0",
    "'''a\nb'''",
    "0o17",
)
NAMES = (
    "x/../../../evil", "/tmp/evil", "..", ".", "wrist (left)", "a b", "$\\\\alpha$ $", "<script>", "CON",
    "x" * 300, "ü" * 200, "; rm -rf /", "%s%n", "x\\ty", "\\u202e", "-rf", "--json", "{}{0}", "''", "a\\nb",
)  # fmt: skip
ESCAPES = ("\\u001b[2J", "\\u0000", "\\u009b31m", "\\u0007", "\\u001b]0;x\\u0007")


class Spoiled(NamedTuple):
    """A text, what was done to it, and whether it has to be refused."""

    text: bytes
    what: str
    must_refuse: bool = False

    def __repr__(self) -> str:
        return f"{self.what}, to be refused {self.must_refuse}: {self.text.decode(errors='replace')}"


def _lines(text: str, wanted: str) -> list[int]:
    """Numbers of the lines of a kind: with a number, with a text, with any value; heads of tables."""
    patterns = {
        "head": r"\[",
        "value": r"[\w.-]+ = ",
        "number": r"[\w.-]+ = -?\d",
        "name": r"(axis|title|name) = \"",
    }
    return [i for i, line in enumerate(text.splitlines()) if re.match(patterns[wanted], line)]


@st.composite
def toml(draw: st.DrawFn, text: str) -> Spoiled:
    """A TOML text with something done to it."""
    lines = text.splitlines()
    kinds = ["none", "key", "odd", "huge", "name", "escape", "bytes", "cut", "drop", "twice", "table", "deep"]
    kind = draw(st.sampled_from(kinds))
    must, where = False, ""
    if kind in ("none", "odd", "huge"):
        i = draw(st.sampled_from(_lines(text, "number" if kind == "none" else "value")))
        value = draw(st.sampled_from({"none": NONE, "odd": ODD, "huge": HUGE}[kind]))
        lines[i] = f"{lines[i].partition(' = ')[0]} = {value}"
        where = f" in {_table(lines, i)}: {lines[i][:60]}"
        must = kind == "none" and "metrics" not in _table(lines, i)  # which may say that nothing was reached
    elif kind == "key":
        i = draw(st.sampled_from(_lines(text, "value")))
        key, _, value = lines[i].partition(" = ")
        other = key + draw(st.sampled_from(("s", "_", "x", "2"))) if draw(st.booleans()) else key[:-1]
        must = other not in {line.partition(" = ")[0] for line in lines} and bool(other) and _closed(lines, i)
        lines[i] = f"{other} = {value}"
        where = f" in {_table(lines, i)}: {lines[i][:60]}"
    elif kind in ("name", "escape"):
        i = draw(st.sampled_from(_lines(text, "name") or _lines(text, "value")))
        value = draw(st.sampled_from(NAMES if kind == "name" else ESCAPES))
        lines[i] = f'{lines[i].partition(" = ")[0]} = "a{value}"'
        must = kind == "escape"
    elif kind == "table":
        lines.append(f"[{draw(st.sampled_from(('bound', 'effect', 'parameter', 'rigs', 'x')))}]\ny = 1")
        must = True
    elif kind == "deep":
        lines.insert(0, f"x = {'[' * 3000}{']' * 3000}")
        must = True
    elif kind in ("drop", "twice"):
        i = draw(st.integers(0, len(lines) - 1))
        lines[i : i + 1] = [] if kind == "drop" else [lines[i], lines[i]]
    content = "\n".join(lines).encode() + b"\n"
    if kind == "bytes":
        content = draw(spoiled_bytes(content))
    elif kind == "cut":
        content = content[: draw(st.integers(0, len(content)))]
    return Spoiled(content, kind + where, must)


def _table(lines: list[str], i: int) -> str:
    return next((line for line in reversed(lines[: i + 1]) if line.startswith("[")), "")


def _closed(lines: list[str], i: int) -> bool:
    """Whether a table may hold known keys alone; what is told of a tuning is for people."""
    return "tuned_on" not in _table(lines, i) and not lines[i].startswith("#")


@st.composite
def spoiled_bytes(draw: st.DrawFn, content: bytes) -> bytes:
    """Bytes, some of which were replaced, put in or taken out."""
    spoiled = bytearray(content)
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, max(len(spoiled) - 1, 0)))
        new = draw(st.binary(max_size=6))
        spoiled[at : at + draw(st.integers(0, 6))] = new
    return bytes(spoiled)


@st.composite
def table(draw: st.DrawFn, text: str) -> Spoiled:
    """A CSV text with something done to it."""
    lines = text.splitlines()
    kind = draw(st.sampled_from(["cell", "bytes", "cut", "column", "twice", "order", "delimiter", "empty"]))
    if kind == "cell":
        i = draw(st.integers(1, min(len(lines) - 1, 400)))
        cells = lines[i].split(",")
        cells[draw(st.integers(0, len(cells) - 1))] = draw(
            st.sampled_from((*NONE, *HUGE, "", " ", "x", '"', "1,2"))
        )
        lines[i] = ",".join(cells)
    elif kind == "column":
        cells = lines[0].split(",")
        cells[draw(st.integers(0, len(cells) - 1))] = draw(
            st.sampled_from(("", "x", "time_s", "angle_deg", "\x1b[2J"))
        )
        lines[0] = ",".join(cells)
    elif kind == "twice":
        i = draw(st.integers(0, min(len(lines) - 1, 400)))
        lines.insert(i, lines[i])
    elif kind == "order":
        i = draw(st.integers(1, min(len(lines) - 2, 400)))
        lines[i], lines[i + 1] = lines[i + 1], lines[i]
    elif kind == "delimiter":
        lines = [line.replace(",", draw(st.sampled_from((";", "\t", "|")))) for line in lines[:50]]
    elif kind == "empty":
        lines = lines[: draw(st.integers(0, 2))]
    content = "\n".join(lines).encode() + b"\n"
    if kind == "bytes":
        content = draw(spoiled_bytes(content[:4000])) + content[4000:]
    elif kind == "cut":
        content = content[: draw(st.integers(0, len(content)))]
    must = kind == "cell" and any(x in content for x in (b"nan,", b"inf,"))
    return Spoiled(content, kind, must)


def shown(path: Path) -> str:
    """The text of a file."""
    return path.read_text(encoding="utf-8")
