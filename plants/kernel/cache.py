"""Machine code of emitted kernels, kept on disk between processes.

What is loaded is run, so it is loaded only from a folder that is the user's own, and only whole: each file
begins with the checksum of the rest.  A file that is damaged is dropped and made anew; where nothing can be
written, kernels are compiled in memory.  Numba's own cache is not used: it would take an index in any
folder that the environment names, and stops at one that is damaged.
"""

import atexit
import hashlib
import linecache
import os
import pickle
import shutil
import sys
import tempfile
import warnings
from collections.abc import Callable
from functools import cache
from pathlib import Path
from stat import S_ISDIR
from types import ModuleType
from typing import Any

from plants.errors import InputError, InputWarning
from plants.files import clear, temporary_prefix, write_atomically

CHECKSUM = 32
"""Bytes that a file begins with: SHA-256 of the rest."""


def _ours(folder: Path) -> bool:
    """Whether nobody else can have put anything into a folder; one that others may read is closed to them."""
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
def _private() -> Path | None:
    """A folder of this process alone, removed at exit; None where there can be none."""
    try:
        clear(Path(tempfile.gettempdir()))
        made = Path(tempfile.mkdtemp(prefix=temporary_prefix()))
    except OSError:
        return None
    atexit.register(remove_private)
    return made


def remove_private() -> None:
    """Remove the folder of this process, if it has one."""
    if _private.cache_info().currsize and (made := _private()) is not None:
        shutil.rmtree(made, ignore_errors=True)


def cache_folder() -> Path | None:
    """Where machine code is kept: between processes where the user's cache is the user's own, else for this
    process alone; None where there is no room for it."""
    import platformdirs

    folder = Path(platformdirs.user_cache_dir("wrist")) / "kernels"
    return folder if _ours(folder) else _private()


def load(source: str) -> Callable[..., None]:
    """The ``run`` of an emitted module, compiled at its first call in any process."""
    from plants.kernel import arithmetic

    of = source.encode() + Path(arithmetic.__file__).read_bytes()  # what it calls is compiled into it
    name = f"k{hashlib.sha256(of).hexdigest()[:24]}"
    loaded, shown = ModuleType(name), f"<{name}>"
    linecache.cache[shown] = (len(source), None, source.splitlines(keepends=True), shown)  # for tracebacks
    sys.modules[name] = loaded  # numba looks there when it reads its cache
    exec(compile(source, shown, "exec"), loaded.__dict__)
    run: Any = loaded.__dict__["run"]
    if hasattr(run, "_cache"):
        run._cache = _kept(name, cache_folder())
    return run  # type: ignore[no-any-return]


def _kept(name: str, folder: Path | None) -> Any:
    """The cache of one dispatcher, as numba asks for it: a file for each signature and processor."""
    from numba import __version__
    from numba.core import config
    from numba.core.caching import NullCache
    from numba.core.compiler import CompileResult
    from numba.core.serialize import dumps

    pickled: Any = dumps

    class Kept(NullCache):
        def load_overload(self, sig: Any, target_context: Any) -> Any:
            target_context.refresh()
            path = place(sig, target_context.codegen())
            if path is None:
                return None
            try:
                content = path.read_bytes()
                if hashlib.sha256(content[CHECKSUM:]).digest() != content[:CHECKSUM]:
                    raise ValueError("damaged")
                rebuilt: Any = CompileResult._rebuild  # which numba does not annotate
                return rebuilt(target_context, *pickle.loads(content[CHECKSUM:]))
            except FileNotFoundError:
                return None
            except Exception:
                _drop(path)
                return None

        def save_overload(self, sig: Any, cres: Any) -> None:
            path = place(sig, cres.codegen)
            if path is None or cres.library.has_dynamic_globals:
                return
            content = pickled(cres._reduce())
            try:
                write_atomically(path, hashlib.sha256(content).digest() + content)
            except InputError as error:
                _say_once(str(error))

    def place(sig: Any, codegen: Any) -> Path | None:
        if folder is None:
            _say_once("there is no folder for compiled kernels; they are compiled anew in every run")
            return None
        checked = getattr(config, "BOUNDSCHECK", None)
        key = (str(sig), codegen.magic_tuple(), __version__, sys.version_info[:3], checked)
        return folder / f"{name}-{hashlib.sha256(repr(key).encode()).hexdigest()[:16]}.kernel"

    return Kept()


def _drop(path: Path) -> None:
    """Remove what stands in a file's place."""
    try:
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)
    except OSError as error:
        _say_once(f"{path}: damaged, and cannot be removed ({error.strerror}); remove it")


@cache
def _say_once(words: str) -> None:
    warnings.warn(words, InputWarning, stacklevel=2)
