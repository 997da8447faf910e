"""Pytrees: nested tuples, NamedTuples and frozen dataclasses as flat lists of leaves."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import fields, is_dataclass
from functools import cache
from typing import Any


@cache
def _fields(kind: type) -> tuple[str, ...] | None:
    """Names of the branches of a dataclass, None for a type that is none.  A field whose metadata says
    ``static`` is no branch: it is the same in every lane, and `like` keeps it.

    Raises TypeError for a dataclass that is not frozen: what is a pytree must not change under a kernel.
    """
    if not is_dataclass(kind):
        return None
    if not kind.__dataclass_params__.frozen:  # type: ignore[attr-defined]
        raise TypeError(f"{kind.__name__}: a dataclass in a pytree must be frozen")
    return tuple(f.name for f in fields(kind) if not f.metadata.get("static"))


def _branches(tree: Any) -> Sequence[Any] | None:
    """Branches of a node, in order; None for a leaf."""
    if isinstance(tree, tuple):
        return tree
    own = _fields(type(tree))  # type: ignore[arg-type]  # a class is hashable; mypy does not see it
    return None if own is None else [getattr(tree, name) for name in own]


def _names(tree: Any) -> Iterable[str]:
    """Names of the branches of a node."""
    if isinstance(tree, tuple):
        return getattr(tree, "_fields", None) or map(str, range(len(tree)))
    return _fields(type(tree)) or ()  # type: ignore[arg-type]


def leaves(tree: Any) -> list[Any]:
    """The leaves, in the order of the fields.

    >>> leaves((1, (2, 3)))
    [1, 2, 3]
    """
    if (branches := _branches(tree)) is None:
        return [tree]
    return [leaf for branch in branches for leaf in leaves(branch)]


def names(tree: Any, prefix: str = "") -> list[str]:
    """The path of each leaf, such as ``memory.h``, in the order of `leaves`."""
    if (branches := _branches(tree)) is None:
        return [prefix]
    return [
        name
        for field, branch in zip(_names(tree), branches, strict=True)
        for name in names(branch, f"{prefix}.{field}" if prefix else field)
    ]


def like(tree: Any, values: Any) -> Any:
    """The same nesting as `tree` with its leaves taken from `values`, in order.

    Nodes are made without their ``__init__``, whose checks of numbers would refuse names and symbols.

    >>> like((0, (0, 0)), [1, 2, 3])
    (1, (2, 3))
    """
    return _fill(tree, iter(values))


def _fill(tree: Any, values: Iterator[Any]) -> Any:
    if (branches := _branches(tree)) is None:
        return next(values)
    filled = [_fill(branch, values) for branch in branches]
    if isinstance(tree, tuple):
        return tuple.__new__(type(tree), filled)
    made = object.__new__(type(tree))
    kept = {f.name: getattr(tree, f.name) for f in fields(tree) if f.metadata.get("static")}
    for name, branch in (kept | dict(zip(_names(tree), filled, strict=True))).items():
        object.__setattr__(made, name, branch)
    return made


def places(tree: Any, kind: type, first: int = 0) -> list[int]:
    """Number of the first leaf of each part of a tree that is of a kind, in the order of `leaves`."""
    found = [first] if isinstance(tree, kind) else []
    for branch in _branches(tree) or ():
        found += places(branch, kind, first)
        first += len(leaves(branch))
    return found
