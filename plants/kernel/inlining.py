"""Laws laid into loops that others write: scalar code for one rollout, such as a period of an MPC."""

import re
from collections.abc import Callable, Sequence
from typing import Any

from plants.kernel import pytrees
from plants.kernel.cache import load
from plants.kernel.emitter import statements
from plants.kernel.graphs import graph
from plants.kernel.templates import module


def inlined(
    law: Callable[..., Any], arguments: list[Any], names: list[list[str]], targets: list[str]
) -> list[str]:
    """Statements in scalar Python of a law on trees like `arguments`, whose leaves are called `names`."""
    return statements(graph(law, *arguments), names, targets)


def scalars(prefix: str, tree: Any) -> list[str]:
    """A variable for each leaf of a tree, such as ``c_lag_keep``."""
    return [f"{prefix}_{n.replace('.', '_')}" for n in pytrees.names(tree)]


def unpacked(names: Sequence[str], array: str) -> list[str]:
    """Statements that read variables from an array."""
    return [f"{n} = {array}[{i}]" for i, n in enumerate(names)]


def compiled(name: str, loop: str, **parts: Sequence[str]) -> Callable[..., None]:
    """The function ``run`` of a loop in plain Python over numbers and arrays, compiled at its first call.

    A line of the loop that is the name of a part in braces is replaced by its statements, indented alike;
    within a line, braces stand for the part's names, with commas.
    """
    for part, lines in parts.items():
        alone = re.search(rf"^( *)\{{{part}\}}$", loop, re.MULTILINE)
        if alone:
            loop = loop.replace(alone[0], "\n".join(alone[1] + line for line in lines))
        loop = loop.replace(f"{{{part}}}", ", ".join(lines))
    return load(module(name, loop))
