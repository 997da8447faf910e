"""Writing files so that a reader never sees half of one, safe names for them, and JSON that any reader takes.

What is written goes under a temporary name first, which tells host and process; what a killed process left
of that kind in a folder is cleared by the next that writes there.
"""

import json
import math
import os
import platform
import re
import shutil
import stat
import tempfile
import unicodedata
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from plants.errors import InputError

LONGEST = 100
"""Characters of a name that is made of a text; file systems take 255 bytes, and endings are added."""


def file_name(text: str) -> str:
    """A text as the name of one file, without its ending: nothing in it leads to another folder, hides the
    file or is refused by a file system.

    >>> file_name("x/../../evil"), file_name("wrist (left)"), file_name("../..")
    ('x-evil', 'wrist (left)', 'unnamed')
    """
    letters = (c if c.isalnum() or c in " ._-+()" else "-" for c in unicodedata.normalize("NFC", text))
    name = re.sub(r"-*(\.\.+-*|-)+", "-", "".join(letters))
    return name.strip(" .-")[:LONGEST].strip(" .-") or "unnamed"


def write_atomically(path: str | Path, content: str | bytes) -> None:
    """Write a file under a temporary name beside its place, then rename it; of a link, the file that it leads
    to.  What is no regular file, such as a device or a pipe, is written to as it stands.

    Raises InputError where the place cannot be written to.
    """
    try:
        with telling(path):
            data = content.encode("utf-8", "replace") if isinstance(content, str) else content
            place = Path(os.path.realpath(path))
            if place.exists() and not stat.S_ISREG(place.stat().st_mode):
                with open(place, "wb") as file:
                    file.write(data)
                return
            place.parent.mkdir(parents=True, exist_ok=True)
            clear(place.parent)
            handle, part = tempfile.mkstemp(dir=place.parent, prefix=temporary_prefix())
            try:
                with os.fdopen(handle, "wb") as file:
                    file.write(data)
                # mkstemp makes files that only their owner can read
                os.chmod(part, stat.S_IMODE(place.stat().st_mode) if place.exists() else 0o666 & ~_mask())
                os.replace(part, place)
            finally:
                Path(part).unlink(missing_ok=True)
    except BrokenPipeError:
        raise InputError(f"{path}: cannot be written (nobody reads it); choose another place") from None


@contextmanager
def telling(path: str | Path) -> Iterator[None]:
    """Within it, what the system says of a place raises InputError, in one line."""
    try:
        yield
    except BrokenPipeError:
        raise
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror}); choose another place") from None
    except ValueError:  # a null character in it
        raise InputError(f"{str(path)!r}: is no name of a file; choose another place") from None


@contextmanager
def replaced_folder(folder: Path) -> Iterator[Path]:
    """A new folder beside, which takes the place of `folder` when all is in it; else it is gone.

    Raises InputError where that cannot be written to.
    """
    with telling(folder):
        folder.parent.mkdir(parents=True, exist_ok=True)
        clear(folder.parent)
        beside = Path(tempfile.mkdtemp(dir=folder.parent, prefix=temporary_prefix()))
        try:
            os.chmod(beside, 0o777 & ~_mask())
            yield beside
            if folder.exists():
                old = Path(tempfile.mkdtemp(dir=folder.parent, prefix=temporary_prefix()))
                os.chmod(beside, stat.S_IMODE(folder.stat().st_mode))
                os.rename(folder, old)  # onto an empty folder
                try:
                    os.rename(beside, folder)
                except OSError:
                    os.rename(old, folder)
                    raise
                shutil.rmtree(old, ignore_errors=True)
            else:
                os.rename(beside, folder)
        finally:
            shutil.rmtree(beside, ignore_errors=True)


def _mask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def temporary_prefix() -> str:
    """What begins the temporary names of this process."""
    return f".wrist-{_host()}-{os.getpid()}-"


def _host() -> str:
    return re.sub(r"\W", "", platform.node())[:20] or "host"


def clear(folder: Path) -> None:
    """Remove what killed processes of this host left under temporary names in a folder."""
    ours = re.compile(rf"\.wrist-{_host()}-(\d+)-\w+")
    with suppress(OSError):
        for entry in list(os.scandir(folder)):
            found = ours.fullmatch(entry.name)
            if found and not _runs(int(found[1])):
                with suppress(OSError):
                    if entry.is_dir(follow_symlinks=False):
                        shutil.rmtree(entry.path, ignore_errors=True)
                    else:
                        os.unlink(entry.path)


def _runs(process: int) -> bool:
    """Whether there is a process of that number."""
    if os.name == "nt":  # where asking would end it
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):
        return True
    return True


def json_text(content: Mapping[str, Any]) -> str:
    """Content as JSON: NumPy types made plain; numbers that JSON lacks, infinite or undefined, null; control
    characters, which a terminal would obey, escaped.

    >>> json_text({"settling_time_s": float("inf")})
    '{\\n "settling_time_s": null\\n}\\n'
    """
    text = json.dumps(_plain(content), indent=1, ensure_ascii=False, allow_nan=False)
    return re.sub(r"[\x7f-\x9f]", lambda m: f"\\u{ord(m[0]):04x}", text) + "\n"


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    return None if isinstance(value, float) and not math.isfinite(value) else value
