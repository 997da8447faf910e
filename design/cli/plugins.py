"""Effects, controllers and hysteresis laws of the user's own, made known before a command runs."""

import sys
from collections.abc import Iterable
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from traceback import extract_tb

from plants.errors import InputError


def load_plugins(paths: Iterable[Path]) -> None:
    """Run Python files that register what is the user's own (`plants.effects.register`,
    `plants.hysteresis.register`, `design.controllers.register`).

    Raises InputError, in one line with the file and its line, for one that is missing, no Python or fails.
    """
    for path in paths:
        _load(path)


def _load(path: Path) -> None:
    if path.suffix != ".py" or not path.is_file():
        raise InputError(f"--plugin: {path} is no Python file; give one that calls a register function")
    name = f"wrist_plugin_{path.stem}"
    spec = spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    sys.modules[name] = module  # dataclasses look their module up
    try:
        spec.loader.exec_module(module)
    except InputError as error:
        raise InputError(f"--plugin: {path}: {error}") from error
    except Exception as error:
        own = [f.lineno for f in extract_tb(error.__traceback__) if f.filename == str(path)]
        line = own[-1] if own else getattr(error, "lineno", None)
        where = f"{path}, line {line}" if line else str(path)
        raise InputError(f"--plugin: {where}: {type(error).__name__}: {error}") from error
