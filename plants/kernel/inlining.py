"""Laws laid into loops that others write: scalar code for one rollout, such as a period of an MPC."""

import re
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from plants.kernel import pytrees
from plants.kernel.cache import load
from plants.kernel.emitter import program
from plants.kernel.graphs import graph
from plants.kernel.templates import module


class Inlined(NamedTuple):
    """A law as a program; the variables that it is called with, and those that its results are put into."""

    program: str
    given: list[str]
    targets: list[str]


def inlined(
    law: Callable[..., Any], arguments: list[Any], names: list[list[str]], targets: list[str]
) -> Inlined:
    """A law on trees like `arguments`, whose leaves are called `names`, for `compiled` to lay into a loop."""
    given = [name for each in names for name in each]
    places = iter(range(len(given)))
    inputs = [[("argument", next(places)) for _ in each] for each in names]
    return Inlined(program(graph(law, *arguments), inputs, [*range(len(targets))]), given, targets)


def scalars(prefix: str, tree: Any) -> list[str]:
    """A variable for each leaf of a tree, such as ``c_lag_keep``."""
    return [f"{prefix}_{n.replace('.', '_')}" for n in pytrees.names(tree)]


def unpacked(names: Sequence[str], array: str) -> list[str]:
    """Statements that read variables from an array."""
    return [f"{n} = {array}[{i}]" for i, n in enumerate(names)]


def compiled(name: str, loop: str, **parts: Sequence[str] | Inlined) -> Callable[..., None]:
    """The function ``run`` of a loop in plain Python over numbers and arrays, compiled at its first call.

    A line of the loop that is the name of a part in braces is replaced by its statements, indented alike, or
    by a call of its law; within a line, braces stand for the part's names, with commas.
    """
    laws = {}
    for part, what in parts.items():
        if isinstance(what, Inlined):
            laws[f"law_{part}"] = f'arithmetic.evaluate("""\\\n{what.program}""")'
            lines = [f"{', '.join(what.targets)}, = law_{part}({', '.join(what.given)})"]
        else:
            lines = [*what]
        alone = re.search(rf"^( *)\{{{part}\}}$", loop, re.MULTILINE)
        if alone:
            loop = loop.replace(alone[0], "\n".join(alone[1] + line for line in lines))
        loop = loop.replace(f"{{{part}}}", ", ".join(lines))
    return load(module(name, loop, **laws))
