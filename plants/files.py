"""Writing files so that a reader never sees half of one."""

import os
import tempfile
from pathlib import Path

from plants.errors import InputError


def write_atomically(path: str | Path, content: str | bytes) -> None:
    """Write a file under a temporary name beside its place, then rename it.

    Raises InputError where the place cannot be written to.
    """
    path = Path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, part = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror}); choose another place") from None
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content.encode() if isinstance(content, str) else content)
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(part, 0o666 & ~mask)  # mkstemp makes files that only their owner can read
        os.replace(part, path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror}); choose another place") from None
    finally:
        Path(part).unlink(missing_ok=True)
