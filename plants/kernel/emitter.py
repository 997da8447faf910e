"""A CasADi graph written down as straight-line Python, which numba compiles."""

from typing import Any

_BINARY = {
    "OP_ADD": "{} + {}", "OP_SUB": "{} - {}", "OP_MUL": "{} * {}", "OP_DIV": "{} / {}",
    "OP_FMIN": "select({0} < {1}, {0}, {1})", "OP_FMAX": "select({0} > {1}, {0}, {1})",
    "OP_LT": "{} < {}", "OP_LE": "{} <= {}", "OP_EQ": "{} == {}", "OP_NE": "{} != {}",
    "OP_IF_ELSE_ZERO": "select({0}, {1}, 0.0)", "OP_CONSTPOW": "{} ** {}", "OP_POW": "{} ** {}",
}  # fmt: skip
_UNARY = {
    "OP_NEG": "-{}", "OP_NOT": "not {}", "OP_SQ": "{0} * {0}", "OP_TWICE": "2.0 * {}",
    "OP_INV": "1.0 / {}", "OP_FABS": "abs({})", "OP_EXP": "math.exp({})", "OP_TANH": "math.tanh({})",
    "OP_SQRT": "math.sqrt({})", "OP_SIN": "math.sin({})", "OP_COS": "math.cos({})",
    "OP_LOG": "math.log({})", "OP_FLOOR": "np.floor({})", "OP_ASSIGN": "{}",
}  # fmt: skip


def statements(function: Any, sources: list[list[str]], targets: list[str]) -> list[str]:
    """Straight-line Python of a CasADi function; reads every input before it writes an output.

    It chooses with `plants.kernel.selection.select`, which the module that it stands in has to import.

    Raises ValueError for an operation that has no code here.
    """
    import casadi

    codes = {v: k for k, v in vars(casadi).items() if k.startswith("OP_") and isinstance(v, int)}
    held: dict[int, str] = {}  # work slot -> the name that was last put there
    made: dict[str, tuple[str, list[str]]] = {}  # name -> how, to recognise a selection
    lines, writes = [], []
    for k in range(function.n_instructions()):
        code = codes[function.instruction_id(k)]
        given, into = function.instruction_input(k), function.instruction_output(k)
        if code == "OP_OUTPUT":
            writes.append(f"{targets[into[1]]} = {held[given[0]]}")
            continue
        if code == "OP_INPUT":
            held[into[0]] = sources[given[0]][given[1]]
            continue
        if code == "OP_CONST":
            held[into[0]] = _constant(float(function.instruction_constant(k)))
            continue
        operands = [held[i] for i in given]
        name = f"t{k}"
        made[name] = (code, operands)
        held[into[0]] = name
        selection = _selection(code, operands, made)
        if selection:
            lines.append(f"{name} = {selection}")
        elif code in _BINARY:
            lines.append(f"{name} = {_BINARY[code].format(*operands)}")
        elif code in _UNARY:
            lines.append(f"{name} = {_UNARY[code].format(operands[0])}")
        else:
            raise ValueError(f"no code for {code}; add it to plants/kernel/emitter.py")
    return lines + writes


def _constant(value: float) -> str:
    """A number as source; in parentheses, since a sign binds less than a power."""
    return f"({value!r})".replace("inf", "np.inf").replace("nan", "np.nan")


def _selection(code: str, operands: list[str], made: dict[str, tuple[str, list[str]]]) -> str | None:
    """One of `a` and `b` where CasADi writes ``(c ? a : 0) + (!c ? b : 0)``, else None."""
    if code != "OP_ADD":
        return None
    parts = [made.get(o, ("", [])) for o in operands]
    if [p[0] for p in parts] != ["OP_IF_ELSE_ZERO"] * 2:
        return None
    (yes, a), (no, b) = parts[0][1], parts[1][1]
    return f"select({yes}, {a}, {b})" if made.get(no) == ("OP_NOT", [yes]) else None
