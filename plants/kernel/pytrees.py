"""Pytrees: nested tuples, NamedTuples and frozen dataclasses as flat lists of leaves."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields, is_dataclass
from functools import cache
from operator import attrgetter
from typing import Any, NamedTuple


class NodeKind(NamedTuple):
    """What nodes of a type have in common: names of the branches, None where they are numbered; names of the
    fields that are no branches; how to read both, in order."""

    names: tuple[str, ...] | None
    static: tuple[str, ...]
    branches: Callable[[Any], Sequence[Any]]
    kept: Callable[[Any], tuple[Any, ...]]


@cache
def _node(kind: type) -> NodeKind | None:
    """What nodes of a type are, None for a type of leaves.  A field whose metadata says ``static`` is no
    branch: it is the same in every lane, and `like` keeps it.

    Raises TypeError for a dataclass that is not frozen: what is a pytree must not change under a kernel.
    """
    if issubclass(kind, tuple):
        return NodeKind(getattr(kind, "_fields", None), (), _itself, _nothing)
    if not is_dataclass(kind):
        return None
    if not kind.__dataclass_params__.frozen:  # type: ignore[attr-defined]
        raise TypeError(f"{kind.__name__}: a dataclass in a pytree must be frozen")
    static = tuple(f.name for f in fields(kind) if f.metadata.get("static"))
    own = tuple(f.name for f in fields(kind) if f.name not in static)
    return NodeKind(own, static, _reader(own), _reader(static))


def _itself(tree: Any) -> Any:
    return tree


def _nothing(_tree: Any) -> tuple[Any, ...]:
    return ()


def _reader(names: tuple[str, ...]) -> Callable[[Any], tuple[Any, ...]]:
    """Some attributes of an object, in order."""
    if len(names) > 1:
        return attrgetter(*names)
    return (lambda tree: (getattr(tree, names[0]),)) if names else _nothing


def leaves(tree: Any) -> list[Any]:
    """The leaves, in the order of the fields.

    >>> leaves((1, (2, 3)))
    [1, 2, 3]
    """
    found: list[Any] = []
    _collect(tree, found)
    return found


def _collect(tree: Any, found: list[Any]) -> None:
    node = _node(type(tree))  # type: ignore[arg-type]  # a class is hashable; mypy does not see it
    if node is None:
        found.append(tree)
    else:
        for branch in node.branches(tree):
            _collect(branch, found)


def structure(tree: Any) -> Any:
    """What trees that nest alike have in common, whatever their leaves: types and fields that are
    no branches; hashable.

    >>> structure((1, (2, 3))) == structure((4, (5, 6))) != structure((1, 2))
    True
    """
    node = _node(type(tree))  # type: ignore[arg-type]
    if node is None:
        return None
    return type(tree), node.kept(tree), tuple([structure(branch) for branch in node.branches(tree)])


def names(tree: Any) -> list[str]:
    """The path of each leaf, such as ``memory.h``, in the order of `leaves`."""
    return list(_paths(structure(tree)))


@cache
def _paths(of: Any) -> tuple[str, ...]:
    """The paths of the leaves of a structure."""
    if of is None:
        return ("",)
    kind, _, branches = of
    own = _node(kind).names or map(str, range(len(branches)))  # type: ignore[union-attr]
    return tuple(
        f"{name}.{path}" if path else name
        for name, branch in zip(own, branches, strict=True)
        for path in _paths(branch)
    )


def like(tree: Any, values: Any) -> Any:
    """The same nesting as `tree` with its leaves taken from `values`, in order.

    Nodes are made without their ``__init__``, whose checks of numbers would refuse names and symbols.

    >>> like((0, (0, 0)), [1, 2, 3])
    (1, (2, 3))
    """
    return _fill(tree, iter(values))


def _fill(tree: Any, values: Iterator[Any]) -> Any:
    kind: Any = type(tree)
    node = _node(kind)
    if node is None:
        return next(values)
    filled = [_fill(branch, values) for branch in node.branches(tree)]
    if isinstance(tree, tuple):
        return tuple.__new__(kind, filled)
    made = object.__new__(kind)
    for name, value in zip(node.static, node.kept(tree), strict=True):
        object.__setattr__(made, name, value)
    for name, value in zip(node.names or (), filled, strict=True):
        object.__setattr__(made, name, value)
    return made


def places(tree: Any, kind: type, first: int = 0) -> list[int]:
    """Number of the first leaf of each part of a tree that is of a kind, in the order of `leaves`."""
    found = [first] if isinstance(tree, kind) else []
    node = _node(type(tree))  # type: ignore[arg-type]
    for branch in node.branches(tree) if node is not None else ():
        found += places(branch, kind, first)
        first += len(leaves(branch))
    return found
