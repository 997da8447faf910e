"""Emitted code and its machine code, kept on disk between processes."""

import hashlib
import importlib.util
import os
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from stat import S_ISDIR
from tempfile import TemporaryDirectory

from plants.files import write_atomically


def _ours(folder: Path) -> bool:
    """Whether nobody else can have put anything into a folder; one that others may read is closed to them.

    What is loaded from it is run: the source, and numba's index, which is a pickle.
    """
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        if not hasattr(os, "getuid"):  # Windows: the folder lies in the user's profile
            return os.access(folder, os.W_OK)
        for place in (folder.parent, folder):  # who may write to the parent may put another in its place
            found = place.lstat()
            if not S_ISDIR(found.st_mode) or found.st_uid != os.getuid() or found.st_mode & 0o022:
                return False
        folder.chmod(0o700)
        return os.access(folder, os.W_OK)
    except OSError:
        return False


@cache
def _private() -> TemporaryDirectory[str]:
    """A folder of this process alone, removed at exit."""
    return TemporaryDirectory(prefix="wrist-kernels-")


def cache_folder() -> Path:
    """Where emitted code and machine code are kept: between processes where the user's cache is the user's
    own, else for this process alone."""
    import platformdirs

    folder = Path(platformdirs.user_cache_dir("wrist")) / "kernels"
    return folder if _ours(folder) else Path(_private().name)


def load(source: str) -> Callable[..., None]:
    """The ``run`` of an emitted module, compiled at its first call in any process."""
    module = f"k{hashlib.sha256(source.encode()).hexdigest()[:24]}"
    path = cache_folder() / f"{module}.py"
    if not path.exists() or path.read_text() != source:  # missing, or damaged
        write_atomically(path, source)  # another process may be doing the same
    spec = importlib.util.spec_from_file_location(module, path)
    assert spec is not None
    assert spec.loader is not None
    loaded = importlib.util.module_from_spec(spec)
    sys.modules[module] = loaded  # numba looks there when it reads its cache
    spec.loader.exec_module(loaded)
    run: Callable[..., None] = loaded.run
    return run
