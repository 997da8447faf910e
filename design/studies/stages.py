"""Stages of a long study that are kept in a folder, so that one that was stopped goes on from what is
finished.

A stage is a function of what it was asked; its result, dictionaries, lists, numbers and text, is kept as
JSON under a key that is the hash of the question and of the workbench's own sources.  Another question, or
another version of any source, is another key, and the stage is done again.
"""

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import design
import plants
from plants.files import json_text, write_atomically


@dataclass(frozen=True)
class Stages:
    """The stages of a study in a folder; None keeps nothing.  read_only: what is found there is taken, and
    nothing is added."""

    folder: Path | None
    read_only: bool = False

    def done(self, name: str, asked: Mapping[str, Any], work: Callable[[], dict[str, Any]]) -> dict[str, Any]:
        """The result of a stage: what was kept under this name of this question, or what `work` gives.

        >>> Stages(None).done("twice", {"x": 2}, lambda: {"y": 4})
        {'y': 4}
        """
        if self.folder is None:
            return _plain(work())
        key = _key(asked)
        path = self.folder / f"{name}.json"
        try:
            kept = json.loads(path.read_text(encoding="utf-8"))
            if isinstance(kept, dict) and kept.get("key") == key:
                return dict(kept["result"])
        except (OSError, ValueError, KeyError):
            pass  # never done, or cut off: done now
        result = _plain(work())
        if self.read_only:
            return result
        write_atomically(path, json_text({"key": key, "asked": dict(asked), "result": result}))
        return result

    def kept(self, name: str, part: Mapping[str, Any]) -> dict[str, Any] | None:
        """The result of a stage of this name whose question has this part, whatever else it was asked; None
        where none was kept by this version of the stages.

        >>> Stages(None).kept("twice", {"x": 2}) is None
        True
        """
        if self.folder is None:
            return None
        try:
            kept = json.loads((self.folder / f"{name}.json").read_text(encoding="utf-8"))
            asked, result = dict(kept["asked"]), dict(kept["result"])
        except (OSError, ValueError, KeyError, TypeError):
            return None  # never done, or cut off
        alike = all(asked.get(k) == v for k, v in _plain(dict(part)).items())
        return result if alike and kept["key"] == _key(asked) else None


@cache
def source_digest() -> str:
    """The hash of the workbench's sources, by which a result of another version is told apart.

    A version that somebody counts up is forgotten: an example was once published with names that the sources
    no longer gave.
    """
    digest = hashlib.sha256()
    for package in (design, plants):
        root = Path(package.__path__[0])
        for path in sorted(root.rglob("*.py")):
            digest.update(str(path.relative_to(root)).encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


def _key(asked: Mapping[str, Any]) -> str:
    """The hash of a question."""
    return hashlib.sha256(json_text({"sources": source_digest(), **asked}).encode()).hexdigest()


NOTHING_KEPT = Stages(None)
"""Every stage is done."""


def _plain(result: dict[str, Any]) -> dict[str, Any]:
    """The result as it is read back, so that a run that goes on gives what a run in one go does."""
    return dict(json.loads(json_text(result)))
