"""A CasADi graph written down as a program, an instruction a line, for `plants.kernel.arithmetic` to read.

An instruction is an operation and its operands, which are earlier lines, counted from 0.  Of ``row``,
``argument`` and ``number`` the operand is the row of an array, the place of an argument and the number
itself; ``into`` has the line of a result, and the row or the place that it goes to.
"""

from typing import Any

_INSTRUCTIONS = {
    "OP_ADD": "add", "OP_SUB": "sub", "OP_MUL": "mul", "OP_DIV": "div", "OP_POW": "pow", "OP_CONSTPOW": "pow",
    "OP_LT": "lt", "OP_LE": "le", "OP_EQ": "eq", "OP_NE": "ne", "OP_NOT": "not", "OP_NEG": "neg",
    "OP_FABS": "abs", "OP_SQRT": "sqrt", "OP_EXP": "exp", "OP_LOG": "log", "OP_SIN": "sin", "OP_COS": "cos",
    "OP_TANH": "tanh", "OP_FLOOR": "floor",
}  # fmt: skip


def program(function: Any, inputs: list[list[tuple[str, int]]], outputs: list[int]) -> str:
    """The program of a CasADi function, which reads every input before it gives an output.

    inputs: the instruction that reads each leaf of each argument, such as ``("row", 3)``; outputs: where each
    leaf of the result goes.  Raises ValueError for an operation that has no instruction here.
    """
    import casadi

    codes = {v: k for k, v in vars(casadi).items() if k.startswith("OP_") and isinstance(v, int)}
    written = _Written()
    held: dict[int, int] = {}  # work slot -> the line that was last put there
    results = {}
    for k in range(function.n_instructions()):
        code = codes[function.instruction_id(k)]
        given, into = function.instruction_input(k), function.instruction_output(k)
        if code == "OP_OUTPUT":
            results[outputs[into[1]]] = held[given[0]]
        elif code == "OP_INPUT":
            held[into[0]] = written.line(*inputs[given[0]][given[1]])
        elif code == "OP_CONST":
            held[into[0]] = written.number(function.instruction_constant(k))
        else:
            held[into[0]] = written.operation(code, [held[i] for i in given])
    for place, line in results.items():
        written.line("into", line, place)
    return "\n".join(written.lines)


class _Written:
    """Lines of a program: an instruction that is there already is not written again."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self._places: dict[str, int] = {}

    def line(self, operation: str, *operands: Any) -> int:
        says = " ".join([operation, *map(str, operands)])
        if says not in self._places:
            self._places[says] = len(self.lines)
            self.lines.append(says)
        return self._places[says]

    def number(self, value: float) -> int:
        return self.line("number", repr(float(value)))

    def operation(self, code: str, of: list[int]) -> int:
        """The line of what CasADi calls a code, of lines."""
        if code == "OP_ADD" and (selection := self._selection(of)):
            return self.line("select", *selection)
        if code in _INSTRUCTIONS:
            return self.line(_INSTRUCTIONS[code], *of)
        match code:
            case "OP_FMIN":
                return self.line("select", self.line("lt", *of), *of)
            case "OP_FMAX":
                return self.line("select", self.line("lt", *reversed(of)), *of)
            case "OP_IF_ELSE_ZERO":
                return self.line("select", *of, self.number(0.0))
            case "OP_SQ":
                return self.line("mul", of[0], of[0])
            case "OP_TWICE":
                return self.line("mul", self.number(2.0), of[0])
            case "OP_INV":
                return self.line("div", self.number(1.0), of[0])
            case "OP_ASSIGN":
                return of[0]
        raise ValueError(f"no instruction for {code}; add it to plants/kernel/emitter.py")

    def _selection(self, of: list[int]) -> list[str] | None:
        """One of two where CasADi writes ``(c ? a : 0) + (!c ? b : 0)``, else None."""
        zero = str(self._places.get("number 0.0"))
        match [self.lines[i].split() for i in of]:
            case [["select", yes, a, z], ["select", no, b, w]] if z == w == zero:
                return [yes, a, b] if self.lines[int(no)] == f"not {yes}" else None
        return None
