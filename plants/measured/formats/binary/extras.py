"""Libraries of formats that not everybody needs: asked for by name where they are missing."""

from importlib import import_module
from typing import Any

from plants.errors import InputError


def needed(module: str, extra: str, where: object) -> Any:
    """A module of an optional dependency.

    Raises InputError, with the line that installs it, where it is missing.

    >>> needed("no_such_module", "tdms", "log.tdms")
    Traceback (most recent call last):
    plants.errors.InputError: log.tdms: this format needs no_such_module; pip install 'wrist-workbench[tdms]'
    """
    try:
        return import_module(module)
    except ModuleNotFoundError:
        raise InputError(
            f"{where}: this format needs {module.split('.')[0]}; pip install 'wrist-workbench[{extra}]'"
        ) from None
