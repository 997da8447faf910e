"""Writing files so that a reader never sees half of one, and JSON that any reader takes."""

import json
import math
import os
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

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


def json_text(content: Mapping[str, Any]) -> str:
    """Content as JSON: NumPy types made plain; numbers that JSON lacks, infinite or undefined, null.

    >>> json_text({"settling_time_s": float("inf")})
    '{\\n "settling_time_s": null\\n}\\n'
    """
    return json.dumps(_plain(content), indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    return None if isinstance(value, float) and not math.isfinite(value) else value
