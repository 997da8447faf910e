"""Nested NamedTuples as flat lists of leaves, so that a kernel can hold them in arrays."""

from collections.abc import Iterator
from typing import Any


def leaves(tree: Any) -> list[Any]:
    """The leaves of nested NamedTuples, in the order of their fields.

    >>> leaves((1, (2, 3)))
    [1, 2, 3]
    """
    if not isinstance(tree, tuple):
        return [tree]
    return [leaf for branch in tree for leaf in leaves(branch)]


def names(tree: Any, prefix: str = "") -> list[str]:
    """The path of each leaf, such as ``memory.h``, in the order of `leaves`."""
    if not isinstance(tree, tuple):
        return [prefix]
    fields = getattr(tree, "_fields", range(len(tree)))
    return [
        name
        for field, branch in zip(fields, tree, strict=True)
        for name in names(branch, f"{prefix}.{field}" if prefix else str(field))
    ]


def like(tree: Any, values: Any) -> Any:
    """The same nesting as `tree` with its leaves taken from `values`, in order.

    >>> like((0, (0, 0)), [1, 2, 3])
    (1, (2, 3))
    """
    return _fill(tree, iter(values))


def _fill(tree: Any, values: Iterator[Any]) -> Any:
    if not isinstance(tree, tuple):
        return next(values)
    filled = [_fill(branch, values) for branch in tree]
    return type(tree)(*filled) if hasattr(tree, "_fields") else tuple(filled)


def places(tree: Any, kind: type, first: int = 0) -> list[int]:
    """Number of the first leaf of each part of a tree that is of a kind, in the order of `leaves`."""
    if not isinstance(tree, tuple):
        return []
    found = [first] if isinstance(tree, kind) else []
    for branch in tree:
        found += places(branch, kind, first)
        first += len(leaves(branch))
    return found
