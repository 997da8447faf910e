"""The arithmetic of a program as one numba intrinsic, which a loop calls like a function.

Statement by statement, numba would find out the type of what is known to be a number, and compile for four
times as long.  Only emitted code imports this, since numba is slow to load.
"""

import math
import operator
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numba import types
from numba.extending import intrinsic

_NUMBER: Any = types.float64
_TUPLE: Any = types.Tuple
_ARGUMENTS: Any = types.StarArgTuple
_ARITHMETIC = {"add": "fadd", "sub": "fsub", "mul": "fmul", "div": "fdiv", "neg": "fneg"}
_COMPARED = {"lt": "<", "le": "<=", "eq": "=="}
_CALLED: dict[str, Any] = {
    "abs": abs, "sqrt": math.sqrt, "exp": math.exp, "log": math.log, "sin": math.sin, "cos": math.cos,
    "tanh": math.tanh, "floor": np.floor, "pow": operator.pow,
}  # fmt: skip
"""Functions that numba has machine code for."""


def advance(program: str, lanes: int) -> Callable[..., None]:
    """``f(rows, lane, *arguments)``: reads and writes a column of a contiguous array, (rows, lanes).

    The rows that a program names are not checked against the array.
    """

    def typed(_context: Any, rows: Any, lane: Any, *arguments: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, given: Any) -> Any:
            data = context.make_array(signature.args[0])(context, builder, given[0]).data

            def place(row: str) -> Any:
                return builder.gep(data, [builder.add(given[1], given[1].type(int(row) * lanes))])

            def read(kind: str, which: str) -> Any:
                if kind == "row":
                    return builder.load(place(which))
                return _argument(context, builder, signature.args[2], given[2], int(which))

            for line, row in _run(program, context, builder, read):
                builder.store(line, place(row))
            return context.get_dummy_value()

        return types.void(rows, lane, _ARGUMENTS(arguments)), code

    return intrinsic(typed)


def evaluate(program: str) -> Callable[..., tuple[float, ...]]:
    """``f(*arguments)``: the results, in the order of their places."""

    def typed(_context: Any, *arguments: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, given: Any) -> Any:
            def read(_kind: str, which: str) -> Any:
                return _argument(context, builder, signature.args[0], given[0], int(which))

            results = {int(place): line for line, place in _run(program, context, builder, read)}
            return context.make_tuple(
                builder, signature.return_type, [results[i] for i in range(len(results))]
            )

        return _TUPLE([_NUMBER] * program.count("into "))(_ARGUMENTS(arguments)), code

    return intrinsic(typed)


def _argument(context: Any, builder: Any, of: Any, given: Any, which: int) -> Any:
    return context.cast(builder, builder.extract_value(given, which), of[which], _NUMBER)


def _run(
    program: str, context: Any, builder: Any, read: Callable[[str, str], Any]
) -> Iterator[tuple[Any, str]]:
    """Instructions for the lines of a program; what goes out, and where to."""
    lines: list[Any] = []
    double = context.get_value_type(_NUMBER)

    def number(line: str) -> Any:
        """The value of a line; what is true or false counts as 1 or 0."""
        value = lines[int(line)]
        return value if value.type == double else builder.uitofp(value, double)

    def truth(line: str) -> Any:
        value = lines[int(line)]
        return builder.fcmp_unordered("!=", value, double(0.0)) if value.type == double else value

    for text in program.splitlines():
        operation, *operands = text.split()
        match operation:
            case "row" | "argument":
                lines.append(read(operation, operands[0]))
            case "number":
                lines.append(double(float(operands[0])))
            case "select":
                condition, yes, no = operands
                lines.append(builder.select(truth(condition), number(yes), number(no)))
            case "ne":  # also of what is no number
                lines.append(builder.fcmp_unordered("!=", *map(number, operands)))
            case "not":
                lines.append(builder.not_(truth(operands[0])))
            case "into":
                yield number(operands[0]), operands[1]
            case _ if operation in _COMPARED:
                lines.append(builder.fcmp_ordered(_COMPARED[operation], *map(number, operands)))
            case _ if operation in _ARITHMETIC:
                lines.append(getattr(builder, _ARITHMETIC[operation])(*map(number, operands)))
            case _:
                function = _CALLED[operation], _NUMBER(*[_NUMBER] * len(operands))
                lines.append(context.get_function(*function)(builder, [*map(number, operands)]))
