"""Function blocks in structured text do what Python does.

No tool at hand runs structured text, so each statement is translated to Python here, by rules of its own,
and run.
"""

import math
import re

import numpy as np
import pytest

from design.export.catalogue import part
from design.export.formats.structured_text import function_block
from design.export.table import of_plays
from design.export.vectors import vector
from plants.errors import InputError
from tests.control.c_target import GAINS, WRIST

STEPS = 1500
KINDS = ["pi", "pi-2dof", "cascade", "lqi", "feedforward-pi", "observer"]


def translated(text):
    """Variables with their start values, and the body as a function of them."""
    text = re.sub(r"\(\*.*?\*\)", "", text, flags=re.DOTALL)
    head, body = re.fullmatch(
        r"\s*FUNCTION_BLOCK \w+\n(.*END_VAR)\n(.*)END_FUNCTION_BLOCK\s*", text, re.DOTALL
    ).groups()
    variables = {}
    for name, kind, start in re.findall(r"^\s+(\w+) : ([^;:]+?)(?: := ([^;]+))?;$", head, re.MULTILINE):
        array = re.match(r"ARRAY\[0\.\.(\d+)\] OF LREAL", kind)
        plain = {"BOOL": False, "INT": 0, "LREAL": 0.0}.get(kind)
        variables[name] = [0.0] * (int(array[1]) + 1) if array else value(start) if start else plain
    lines, depth = [], 1
    for line in filter(None, map(str.strip, body.split("\n"))):
        if line in ("END_IF;", "END_FOR;"):
            depth -= 1
            continue
        if line == "ELSE":
            lines.append("    " * (depth - 1) + "else:")
            continue
        asked = re.fullmatch(r"IF (.*) THEN", line)
        loop = re.fullmatch(r"FOR (\w+) := (\w+) TO (\w+) DO", line)
        told = re.fullmatch(r"(\w+)(\[.*?\])? := (.*);", line)
        assert asked or loop or told, line
        if asked:
            said = f"if {expression(asked[1])}:"
        elif loop:
            said = f"for v.{loop[1]} in range({loop[2]}, {loop[3]} + 1):"
        else:
            said = f"v.{told[1]}{expression(told[2] or '')} = {expression(told[3])}"
        lines.append("    " * depth + said)
        depth += bool(asked or loop)
    scope = {
        "SEL": lambda g, a, b: b if g else a, "MAX": lambda a, b: b if a < b else a,
        "MIN": lambda a, b: b if b < a else a, "ABS": abs, "EXP": math.exp, "LN": math.log, "SQRT": math.sqrt,
    }  # fmt: skip
    exec("def run(v):\n" + "\n".join(lines), scope)
    return variables, scope["run"]


def value(text):
    return {"TRUE": True, "FALSE": False}.get(text) if text in ("TRUE", "FALSE") else float(text)


def expression(text):
    words = {"AND": "and", "OR": "or", "NOT": "not", "MOD": "%", "TRUE": "True", "FALSE": "False"}

    def one(found):
        word = found[0]
        if word in ("<=", ">=", "<>", "="):
            return {"<>": "!=", "=": "=="}.get(word, word)
        if word[0].isdigit() or word in ("SEL", "MAX", "MIN", "ABS", "EXP", "LN", "SQRT"):
            return word
        return words.get(word, f"v.{word}")

    return re.sub(r"\d+\.?\d*(?:E[-+]?\d+)?|\w+|<=|>=|<>|=", one, text)


class Variables:
    """Those of one block."""


@pytest.mark.slow
@pytest.mark.parametrize("wrist", [WRIST, of_plays(WRIST)], ids=["four segments", "plays"])
@pytest.mark.parametrize("kind", KINDS)
def test_a_block_replays_the_vector(kind, wrist):
    made = part(kind, "flexion", wrist, GAINS[kind])
    found = vector(made, wrist, STEPS)
    variables, run = translated(function_block(made))
    block = Variables()
    vars(block).update(variables)
    block.start_pressure_kPa, block.start_angle_deg = found.pressure, found.angle
    worst, codes = 0.0, set()
    for row in found.rows:
        for i, f in made.read:
            setattr(block, f.member, float(row[i]))
        run(block)
        worst = max(worst, abs(getattr(block, made.output.member) - row[3]))
        codes.add(block.code)
    assert worst <= 1e-9
    assert codes == {0, 1, 3}


def test_a_block_stays_in_its_range_whatever_it_is_given():
    made = part("pi", "flexion", WRIST, (1e5, 1e5))
    variables, run = translated(function_block(made))
    block, draw = Variables(), np.random.default_rng(0)
    vars(block).update(variables)
    for k in range(2000):
        hostile = draw.choice([np.nan, np.inf, -np.inf, 1e308, 0.0, *draw.uniform(-50.0, 50.0, 4)], 4)
        block.start_pressure_kPa, block.start_angle_deg, block.reference_deg, block.angle_deg = map(
            float, hostile
        )
        block.begin = k % 100 == 0
        run(block)
        assert 0.0 <= block.command_V <= 4.0


@pytest.mark.parametrize("title", ["x *) evil (* y", "a\nb"])
def test_a_title_does_not_leave_its_comment(title):
    from dataclasses import replace

    made = replace(part("pi", "flexion", WRIST, (1.0, 2.0)), title=title)
    assert "evil" not in re.sub(r"\(\*.*?\*\)", "", function_block(made), flags=re.DOTALL)


@pytest.mark.parametrize(
    "name", ['x; system("ls")', "../../evil", "<script>", r"$\alpha$", "a\nb", "\x1b[31m"]
)
def test_a_name_becomes_one_that_every_target_takes(name):
    made = part("pi", name, WRIST, (1.0, 2.0))
    assert re.fullmatch(r"[a-z]\w*", made.name, re.ASCII)
    assert "__" not in made.name  # which IEC 61131-3 forbids
    assert f"FUNCTION_BLOCK {made.name}\n" in function_block(made)


def test_an_MPC_is_refused():
    with pytest.raises(InputError, match="is no function block"):
        function_block(part("mpc", "flexion", WRIST))
