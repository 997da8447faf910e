"""The deepest stack of a program, of the call graphs that GCC writes (``-fcallgraph-info=su``)."""

import re
from collections.abc import Iterable
from functools import cache

from plants.errors import InputError

_NODE = re.compile(r'node: \{ title: "([^"]+)" label: "([^"]+)"')
_EDGE = re.compile(r'edge: \{ sourcename: "([^"]+)" targetname: "([^"]+)"')
_FRAME = re.compile(r"(\d+) bytes \(([\w,]+)\)")


def deepest(graphs: Iterable[str], start: str) -> tuple[int, frozenset[str]]:
    """Stack [bytes] of the worst path of calls from a function, its own frame included, and the functions
    that are called without being in the graphs, whose frames are not known and not counted.

    Raises InputError for recursion, a call through a pointer and a frame without a bound.

    >>> text = '''node: { title: "f" label: "f\\\\nx.c:1:1\\\\n16 bytes (static)" }
    ... node: { title: "g" label: "g\\\\nx.c:2:1\\\\n40 bytes (static)" }
    ... edge: { sourcename: "f" targetname: "g" }
    ... edge: { sourcename: "g" targetname: "sqrt" }'''
    >>> deepest([text], "f")
    (56, frozenset({'sqrt'}))
    """
    frames: dict[str, int] = {}
    calls: dict[str, set[str]] = {}
    for graph in graphs:
        for title, label in _NODE.findall(graph):
            frame = _FRAME.search(label)
            if frame is not None:
                if "dynamic" in frame[2] and "bounded" not in frame[2]:
                    raise InputError(f"{title}: a frame without a bound")
                frames[title] = int(frame[1])
        for source, target in _EDGE.findall(graph):
            if target == "__indirect_call":
                raise InputError(f"{source}: calls through a pointer")
            calls.setdefault(source, set()).add(target)
    entered: set[str] = set()

    @cache
    def below(title: str) -> int:
        if title in entered:
            raise InputError(f"{title}: calls itself")
        entered.add(title)
        found = frames.get(title, 0) + max((below(t) for t in calls.get(title, ())), default=0)
        entered.discard(title)
        return found

    depth = below(start)
    reached, todo = set(), [start]
    while todo:
        title = todo.pop()
        if title not in reached:
            reached.add(title)
            todo += calls.get(title, ())
    return depth, frozenset(reached - frames.keys())
