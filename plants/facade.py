"""Names of a package that are imported when they are first used, so that the command starts fast."""

from collections.abc import Mapping
from importlib import import_module
from typing import Any


def named(package: str, homes: Mapping[str, str], name: str) -> Any:
    """What a package's ``__getattr__`` returns for a name.

    homes: for each name the module that has it, and after a colon what it is called there where that is
    something else.

    >>> named("mathematics", {"root": "math:sqrt"}, "root")(9.0)
    3.0

    Raises AttributeError for a name that is not in homes.
    """
    if name not in homes:
        raise AttributeError(f"module {package!r} has no attribute {name!r}")
    module, _, there = homes[name].partition(":")
    return getattr(import_module(module), there or name)
