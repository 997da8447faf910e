"""Pytrees: nested tuples, NamedTuples and frozen dataclasses as flat lists of leaves."""

from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from typing import Any


def _branches(tree: Any) -> dict[str, Any] | None:
    """Branches of a node by their names, in order; None for a leaf.  A field of a dataclass whose metadata
    says ``static`` is none: it is the same in every lane, and `like` keeps it.

    Raises TypeError for a dataclass that is not frozen: what is a pytree must not change under a kernel.
    """
    if isinstance(tree, tuple):
        names = getattr(tree, "_fields", map(str, range(len(tree))))
        return dict(zip(names, tree, strict=True))
    if is_dataclass(tree) and not isinstance(tree, type):
        if not tree.__dataclass_params__.frozen:  # type: ignore[attr-defined]
            raise TypeError(f"{type(tree).__name__}: a dataclass in a pytree must be frozen")
        return {f.name: getattr(tree, f.name) for f in fields(tree) if not f.metadata.get("static")}
    return None


def leaves(tree: Any) -> list[Any]:
    """The leaves, in the order of the fields.

    >>> leaves((1, (2, 3)))
    [1, 2, 3]
    """
    if (branches := _branches(tree)) is None:
        return [tree]
    return [leaf for branch in branches.values() for leaf in leaves(branch)]


def names(tree: Any, prefix: str = "") -> list[str]:
    """The path of each leaf, such as ``memory.h``, in the order of `leaves`."""
    if (branches := _branches(tree)) is None:
        return [prefix]
    return [
        name
        for field, branch in branches.items()
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
    filled = {name: _fill(branch, values) for name, branch in branches.items()}
    if isinstance(tree, tuple):
        return tuple.__new__(type(tree), filled.values())
    made = object.__new__(type(tree))
    kept = {f.name: getattr(tree, f.name) for f in fields(tree) if f.metadata.get("static")}
    for name, branch in (kept | filled).items():
        object.__setattr__(made, name, branch)
    return made


def places(tree: Any, kind: type, first: int = 0) -> list[int]:
    """Number of the first leaf of each part of a tree that is of a kind, in the order of `leaves`."""
    found = [first] if isinstance(tree, kind) else []
    for branch in (_branches(tree) or {}).values():
        found += places(branch, kind, first)
        first += len(leaves(branch))
    return found
