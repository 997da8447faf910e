"""Places to write to, looked at before the work is done rather than after."""

import os
from collections.abc import Mapping
from pathlib import Path

from design.cli.terminal.screen import is_stdout


def check_places(files: Mapping[str, Path | None], folder: Path | None = None) -> None:
    """Find a place that cannot be written to before the work begins.

    files: by the option that names them, standard output allowed for ``--json``; folder: of ``--out``.
    Raises InputError, naming the option.
    """
    from plants.errors import InputError
    from plants.files import telling

    taken: dict[str, str] = {}
    for option, path in files.items():
        if path is not None and not (option == "--json" and is_stdout(path)):
            _check_place(option, path, folder=False)
            with telling(path):
                place = os.path.realpath(path)
            if place in taken:
                raise InputError(f"{option}: {path} is where {taken[place]} goes; give another place")
            taken[place] = option
    if folder is not None:
        _check_place("--out", folder, folder=True)


def _check_place(option: str, path: Path, folder: bool) -> None:
    import tempfile

    from plants.errors import InputError
    from plants.files import telling, temporary_prefix

    if path.is_dir() and not folder:
        raise InputError(f"{option}: {path} is a folder; give the name of a file")
    if path.exists() and not path.is_dir() and folder:
        raise InputError(f"{option}: {path} is a file; give a folder")
    with telling(f"{option}: {path}"):
        if path.exists() and not path.is_file() and not folder:  # a device or a pipe is written to as it is
            if not os.access(path, os.W_OK):
                raise PermissionError(13, "Permission denied")
            return
        there = path if folder else Path(os.path.realpath(path)).parent
        while not there.exists() and there != there.parent:
            there = there.parent
        handle, name = tempfile.mkstemp(dir=there, prefix=temporary_prefix())
        os.close(handle)
        Path(name).unlink()
