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
    for option, path in files.items():
        if path is not None and not (option == "--json" and is_stdout(path)):
            _check_place(option, path, folder=False)
    if folder is not None:
        _check_place("--out", folder, folder=True)


def _check_place(option: str, path: Path, folder: bool) -> None:
    import tempfile

    from plants.errors import InputError

    if path.is_dir() and not folder:
        raise InputError(f"{option}: {path} is a folder; give the name of a file")
    if path.exists() and not path.is_dir() and folder:
        raise InputError(f"{option}: {path} is a file; give a folder")
    there = path if folder else path.parent
    while not there.exists() and there != there.parent:
        there = there.parent
    try:
        handle, name = tempfile.mkstemp(dir=there, prefix=".wrist-")
    except OSError as error:
        raise InputError(
            f"{option}: {path}: cannot be written ({error.strerror}); choose another place"
        ) from None
    os.close(handle)
    Path(name).unlink()
