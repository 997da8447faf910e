"""IEC 61131-3 structured text: a function block that does what the C does.

The law is the straight line of operations that CasADi writes as C, told statement by statement in structured
text; what surrounds it (readings that are not believed, delay lines, the range of the output) is that of the
templates of C.  A block is called once in every period, as a cyclic task of that period does.
"""

import re
from collections.abc import Iterator

from design.controllers.measurement.plausible import UNSEEN
from design.export.part import Part
from design.export.rendering import render
from plants.errors import InputError

_FUNCTION = re.compile(
    r"/\* (?P<name>\w+):\(.*?\n(?:static )?int casadi_f\d+\([^\n]*\{\n(?P<body>.*?)\n\}", re.DOTALL
)
_CALLS = {
    "casadi_fmax": "MAX", "casadi_fmin": "MIN", "casadi_fabs": "ABS", "exp": "EXP", "log": "LN",
    "sqrt": "SQRT",
}  # fmt: skip
_NUMBER = r"(?<![\w.])\d+\.?\d*(?:[eE][-+]?\d+)?"
_NAME = rf"-?(?:a\d+|{_NUMBER})"
_RULES: tuple[tuple[str, str], ...] = (
    (r"\((%s)([-+*/])(%s)\)", r"(\1 \2 \3)"),
    (r"\((%s)(<=?)(%s)\)", r"SEL(\1 \2 \3, 0.0, 1.0)"),
    (r"\((%s)==(%s)\)", r"SEL(\1 = \2, 0.0, 1.0)"),
    (r"\((%s)!=(%s)\)", r"SEL(\1 <> \2, 0.0, 1.0)"),
    (r"\((%s)&&(%s)\)", r"SEL((\1 <> 0.0) AND (\2 <> 0.0), 0.0, 1.0)"),
    (r"\((%s)\|\|(%s)\)", r"SEL((\1 <> 0.0) OR (\2 <> 0.0), 0.0, 1.0)"),
    (r"\(!(%s)\)", r"SEL(\1 <> 0.0, 1.0, 0.0)"),
    (r"\(-\s*(%s)\)", r"(-\1)"),
    (r"\((%s)\?(%s):0\)", r"SEL(\1 <> 0.0, 0.0, \2)"),
    (r"\((%s)\?(%s):(%s)\)", r"SEL(\1 <> 0.0, \3, \2)"),
    (r"casadi_sq\((%s)\)", r"(\1 * \1)"),
    (r"(-?a\d+)", r"\1"),
)
"""Forms of CasADi's expressions, and what they are in structured text, where a truth is no number."""


def function_block(part: Part) -> str:
    """The function block of a part, as text.

    Raises InputError for a law that is no straight line of operations: an MPC solves a programme.
    """
    laws = {m["name"]: m["body"] for m in _FUNCTION.finditer(part.code)}
    wanted = [f"{part.name}_init_law", f"{part.name}_step_law"]
    if part.template != "law.c.jinja" or not set(wanted) <= set(laws):
        raise InputError(f"--target st: {part.title} is no function block; export it with --target c")
    begin, step = (list(_statements(laws[n], n)) for n in wanted)
    used = re.findall(r"\ba\d+\b", "\n".join([*begin, *step]))
    numbers = [f"a{i}" for i in range(1 + max((int(a[1:]) for a in used), default=0))]
    return render(
        "block.st.jinja", part, begin=begin, law=step, numbers=numbers, leaves=len(part.state),
        number=literal, UNSEEN_ST=literal(UNSEEN),
    )  # fmt: skip


def literal(value: float) -> str:
    """A number as structured text has it: with a point, and an exponent in capitals.

    >>> literal(1.0), literal(1e-09), literal(-0.5)
    ('1.0', '1.0E-9', '-0.5')
    """
    base, _, exponent = repr(float(value)).partition("e")
    base = base if "." in base else f"{base}.0"
    return f"{base}E{int(exponent)}" if exponent else base


def _statements(body: str, law: str) -> Iterator[str]:
    """The statements of a function of CasADi, in structured text.

    >>> list(_statements("  a0=arg[0][2];\\n  a1=(a0<a0);\\n  res[0][3]=a1;", "f"))
    ['a0 := given[2];', 'a1 := SEL(a0 < a0, 0.0, 1.0);', 'after[3] := a1;']
    """
    for line in map(str.strip, body.split("\n")):
        if not line or line.startswith(("(void)", "casadi_real ", "return ")):
            continue
        stored = re.fullmatch(r"res\[0\]\[(\d+)\]=(.*);", line)
        named = re.fullmatch(r"(a\d+)=(.*);", line)
        if stored:
            yield f"after[{stored[1]}] := {_expression(_plain(stored[2]), law)};"
        elif named:
            yield f"{_plain(named[1])} := {_expression(_plain(named[2]), law)};"
        else:
            raise InputError(
                f"{law}: {line!r} has no counterpart in structured text; export it with --target c"
            )


def _plain(text: str) -> str:
    """Names without leading zeros, so that they are one to a reader who takes them for numbers."""
    return re.sub(r"\ba0+(\d)", r"a\1", text)


def _expression(text: str, law: str) -> str:
    given = re.fullmatch(r"arg\[(\d)\]\[(\d+)\]", text)
    if given:
        return f"{'seen' if given[1] == '1' else 'given'}[{given[2]}]"
    if re.fullmatch(r"-?\d+\.?\d*(e[-+]?\d+)?", text):
        return literal(float(text))
    for form, to in _RULES:
        form = form.replace("%s", _NAME)
        if re.fullmatch(form, text):
            told = re.sub(form, to, text)
            return re.sub(_NUMBER, lambda number: literal(float(number[0])), told)
    called = re.fullmatch(rf"(\w+)\(({_NAME})(?:,({_NAME}))?\)", text)
    if called and called[1] in _CALLS:
        inside = ", ".join(filter(None, called.groups()[1:]))
        return f"{_CALLS[called[1]]}({inside})"
    raise InputError(f"{law}: {text!r} has no counterpart in structured text; export it with --target c")
