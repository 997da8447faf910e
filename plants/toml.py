"""Reading TOML strictly: every file of a user goes through here, and what is not understood is refused.

A key that nobody knows would be a wish that is silently not met (`bound` for `bounds`), a number that is
none a rule that silently holds.  Errors are one line: file, table, key, what to do.
"""

import tomllib
import unicodedata
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Any, TypeGuard

from plants.errors import InputError

LARGEST_FILE = 16_000_000
"""Bytes; text of parameters is a thousand times shorter."""

LARGEST, SMALLEST = 1e12, 1e-12
"""Magnitudes beyond which no quantity of a rig lies; 0 is none."""


def read_toml(path: str | Path, what: str, example: str) -> dict[str, Any]:
    """The tables of a file.  `what` it should be and an `example` of it are for the errors.

    Raises InputError, in one line that begins with the path, for a file that cannot be read, and as
    `parse_toml`.
    """
    path = Path(path)
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST_FILE + 1)
    except FileNotFoundError:
        raise InputError(f"{path}: no such {what}; give a .toml file that exists") from None
    except IsADirectoryError:
        raise InputError(f"{path}: is a folder; give the .toml file of a {what}") from None
    except OSError as error:
        raise InputError(
            f"{path}: cannot be read ({error.strerror}); give the .toml file of a {what}"
        ) from None
    except ValueError:  # a null character in the name
        raise InputError(f"{str(path)!r}: is no name of a file; give the .toml file of a {what}") from None
    return parse_toml(content, path, f"see {example}")


def parse_toml(content: bytes, where: str | Path, advice: str) -> dict[str, Any]:
    """The tables of a text in UTF-8; `where` begins the errors, `advice` ends them.

    Raises InputError for what is no TOML, is nested or long beyond reason, and for control characters, which
    a terminal would obey.
    """
    if len(content) > LARGEST_FILE:
        raise InputError(f"{where}: more than {LARGEST_FILE // 1_000_000} MB; {advice}")
    try:
        table = tomllib.loads(content.decode("utf-8-sig"))
        for key, value in _walk(table):
            _check(key, value)
    except RecursionError:
        raise InputError(f"{where}: not valid TOML (nested too deeply); {advice}") from None
    except ValueError as error:  # of tomllib, of UTF-8, and for an integer of thousands of digits
        raise InputError(f"{where}: not valid TOML ({' '.join(str(error).split())}); {advice}") from None
    return table


def _walk(value: Any, key: str = "") -> Iterator[tuple[str, Any]]:
    """Everything in tables and lists, with the key that it stands under."""
    if isinstance(value, dict):
        for name, inner in value.items():
            yield name, name
            yield from _walk(inner, name)
    elif isinstance(value, list):
        for inner in value:
            yield from _walk(inner, key)
    else:
        yield key, value


def _check(key: str, value: Any) -> None:
    if isinstance(value, str) and any(unicodedata.category(c) == "Cc" and c not in "\n\t" for c in value):
        raise ValueError(f"{key[:40]!r} holds a control character")
    if isinstance(value, int) and abs(value) > 2**63:
        raise ValueError(f"{key[:40]!r} is an integer beyond 64 bits")


def check_keys(table: Mapping[str, Any], known: Collection[str], where: str) -> None:
    """Raise InputError for the first key that is not known."""
    unknown = next((k for k in table if k not in known), None)
    if unknown is not None:
        raise InputError(f"{where}: unknown key {unknown!r}; known are {', '.join(known)}")


def is_number(value: Any) -> TypeGuard[float]:
    """Whether a value of TOML is a finite number; true and false are none."""
    return isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value)


@dataclass(frozen=True)
class Reader:
    """Values of tables, with errors of one line that begin with where they stand."""

    where: str
    example: str

    def table(self, table: Mapping[str, Any], name: str, known: tuple[str, ...]) -> Mapping[str, Any]:
        """A table whose keys are all known; raises InputError for another."""
        check_keys(table, known, f"{self.where}: {name}")
        return table

    def get(self, table: Mapping[str, Any], key: str, kind: type) -> Any:
        """A value of a kind; raises InputError for another."""
        if not isinstance(table.get(key), kind):
            raise InputError(f"{self.where}: {key} is missing or no {kind.__name__}; see {self.example}")
        return table[key]

    def text(self, table: Mapping[str, Any], key: str) -> str:
        """A text that is not empty; raises InputError for another."""
        found: str = self.get(table, key, str)
        if not found.strip():
            raise InputError(f"{self.where}: {key} is empty; see {self.example}")
        return found

    def number(self, value: Any, key: str) -> float:
        """A finite number of a magnitude that a rig can have; raises InputError for another."""
        if not is_number(value):
            raise InputError(f"{self.where}: {key} = {value!r} is not a finite number")
        if value != 0.0 and not SMALLEST <= abs(value) <= LARGEST:
            raise InputError(f"{self.where}: {key} = {value:g} is beyond {SMALLEST:g} to {LARGEST:g}")
        return float(value)

    def positive(self, table: Mapping[str, Any], key: str) -> float:
        """A number above 0; raises InputError for another."""
        found = self.number(table.get(key), key)
        if found <= 0.0:
            raise InputError(f"{self.where}: {key} = {found:g} must be positive")
        return found

    def not_negative(self, table: Mapping[str, Any], key: str) -> float:
        """A number that is not below 0, 0 where there is none; raises InputError for another."""
        found = self.number(table.get(key, 0.0), key)
        if found < 0.0:
            raise InputError(f"{self.where}: {key} = {found:g} must not be negative")
        return found

    def share(self, table: Mapping[str, Any], key: str) -> float:
        """A number from 0 to below 1; raises InputError for another."""
        found = self.number(table.get(key), key)
        if not 0.0 <= found < 1.0:
            raise InputError(f"{self.where}: {key} = {found:g} must be a share from 0 to below 1")
        return found

    def pair(self, table: Mapping[str, Any], key: str, equal: bool = False) -> tuple[float, float]:
        """Two numbers, the lower first; raises InputError for another."""
        value = self.get(table, key, list)
        if len(value) != 2:
            raise InputError(f"{self.where}: {key} must be two numbers, lower and upper")
        low, high = self.number(value[0], key), self.number(value[1], key)
        if not (low < high or (equal and low == high)):
            raise InputError(f"{self.where}: {key} = {low:g}, {high:g}: the lower comes first")
        return low, high
