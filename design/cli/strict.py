"""What every command asks of its line before it begins: each option once, numbers that can be meant, names
that a file can have."""

import math
import os
from collections.abc import Iterable
from contextvars import ContextVar
from pathlib import Path
from typing import Any

from typer.core import TyperCommand, TyperGroup

from design.cli.panels import OUTPUT, grouped

LARGEST, SMALLEST = 1e6, 1e-9
"""Magnitudes between which every option's number lies, but for 0."""

LONGEST_NAME = 255
"""Bytes of a file's name; file systems take no more."""

_GIVEN: ContextVar[frozenset[str]] = ContextVar("given", default=frozenset())


def given(option: str) -> bool:
    """Whether an option, such as ``--axis``, stands in the line that runs."""
    return option in _GIVEN.get()


def refuse(options: Iterable[str], why: str) -> None:
    """Raise InputError for the first of these options that was given, though it would do nothing."""
    from plants.errors import InputError

    for option in options:
        if given(option):
            raise InputError(f"{option}: {why}; leave it out")


class PlainGroup(TyperGroup):
    """The command ``wrist`` itself, whose switches show no type."""

    def get_params(self, ctx: Any) -> list[Any]:
        """The parameters, switches without a type."""
        found = super().get_params(ctx)
        for p in found:
            if getattr(p, "is_flag", False) or p.name == "help":
                p.metavar = ""
        return found


class StrictCommand(TyperCommand):
    """A command whose line is checked as a whole, and whose help groups its options."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Group the options, then write the help."""
        self.params = grouped(self.params)
        super().format_help(ctx, formatter)

    def get_params(self, ctx: Any) -> list[Any]:
        """The parameters with that of ``--help``, which shows no type either."""
        found: list[Any] = super().get_params(ctx)
        for p in found:
            if p.name == "help":
                p.metavar, p.rich_help_panel = "", OUTPUT
        return found

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse, and raise InputError for what is parsed but cannot be meant."""
        if not ctx.resilient_parsing:
            names = self._named(ctx, args)
            _GIVEN.set(frozenset(names))
        rest = super().parse_args(ctx, args)
        if not ctx.resilient_parsing:
            for parameter in self.get_params(ctx):
                option = parameter.opts[0] if parameter.opts[0].startswith("-") else parameter.name
                for value in _values(ctx.params.get(parameter.name)):
                    _check(str(option), value)
        return rest

    def _named(self, ctx: Any, args: list[str]) -> list[str]:
        """The options of a line, by their long names."""
        from plants.errors import InputError

        _, _, order = self.make_parser(ctx).parse_args(args=list(args))
        found: list[str] = []
        for parameter in order:
            name = next((o for o in parameter.opts if o.startswith("--")), None)
            if name is None:
                continue
            if name in found and not parameter.multiple and not getattr(parameter, "is_flag", False):
                raise InputError(f"{name}: given twice; give it once")
            found.append(name)
        return found


def _values(value: Any) -> list[Any]:
    return list(value) if isinstance(value, list | tuple) else [value]


def _check(option: str, value: Any) -> None:
    """Raise InputError for a number that is none, or beyond reason, a text that is no name."""
    from plants.errors import InputError

    if isinstance(value, float):
        if not math.isfinite(value):
            raise InputError(f"{option}: {value} is not a finite number; give one")
        if value != 0.0 and not SMALLEST <= abs(value) <= LARGEST:
            raise InputError(
                f"{option}: {value:g} is beyond {SMALLEST:g} to {LARGEST:g}; give a number that can be meant"
            )
    elif isinstance(value, int) and abs(value) >= 2**63:
        raise InputError(f"{option}: a number of {len(str(value))} digits; give a smaller one")
    elif isinstance(value, str | Path):
        text = str(value)
        if "\0" in text:
            raise InputError(f"{option}: {text!r} holds a null character; give another")
        try:
            text.encode()
        except UnicodeEncodeError:
            raise InputError(f"{option}: {text!r} is not in UTF-8; rename it, or give another") from None
        if isinstance(value, Path) and any(len(os.fsencode(p)) > LONGEST_NAME for p in value.parts):
            raise InputError(f"{option}: a name of more than {LONGEST_NAME} bytes; give a shorter one")
