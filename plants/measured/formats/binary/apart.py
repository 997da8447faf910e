"""Reading in a process of its own, for formats whose C libraries damaged bytes bring down.

A file of MATLAB or HDF5 is parsed by C that trusts it: some flipped bytes end the whole process, some make
it search for ever.  Here that is the end of a worker, which is started again for the next file.
"""

import atexit
import os
import pickle
import select
import subprocess
import sys
from pathlib import Path
from typing import Any

from plants.errors import InputError

PATIENCE = 300.0
"""Time after which a reader that says nothing is given up [s]."""

LINES = "import sys; sys.path[:] = {path!r}; from plants.measured.formats.binary.apart import serve; serve()"

_worker: tuple[int, subprocess.Popen[bytes]] | None = None
"""The process that made the worker, and the worker: a forked process must not share its pipes."""


def apart(module: str, function: str, path: Path) -> Any:
    """What `function` of a module makes of a file, run in another process.

    Raises InputError where the reader raises it, and where the file ends the reader's process.
    """
    worker = _running()
    assert worker.stdin is not None
    assert worker.stdout is not None
    try:
        _send(worker.stdin, (module, function, path, os.getcwd()))
        if not select.select([worker.stdout], [], [], PATIENCE)[0]:
            raise EOFError
        ended, answer = pickle.load(worker.stdout)
    except (EOFError, OSError, pickle.UnpicklingError):
        stop()
        raise InputError(
            f"{path}: its reader broke down over it; the file is damaged: export it again"
        ) from None
    if ended == "refused":
        raise InputError(answer)
    return answer


def stop() -> None:
    """End the worker, if there is one."""
    global _worker
    if _worker is not None and _worker[0] == os.getpid():
        with _worker[1] as worker:
            worker.kill()
    _worker = None


def serve() -> None:
    """The worker: answers one request after another until its input ends."""
    from importlib import import_module

    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a library prints must not stand among the answers
    while True:
        try:
            module, function, path, folder = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        try:
            os.chdir(folder)  # the one that asks may have moved since the worker was started
            answer = "read", getattr(import_module(module), function)(path)
        except InputError as error:
            answer = "refused", str(error)
        except Exception as error:  # damaged bytes make readers raise nearly anything
            said = " ".join(str(error).split()) or type(error).__name__
            answer = "refused", f"{path}: cannot be read ({said[:200]}); it may be cut off: export it again"
        _send(answers, answer)


def _send(to: Any, what: object) -> None:
    pickle.dump(what, to)
    to.flush()


def _running() -> subprocess.Popen[bytes]:
    global _worker
    if _worker is None or _worker[0] != os.getpid() or _worker[1].poll() is not None:
        stop()
        line = [sys.executable, "-c", LINES.format(path=[p or os.getcwd() for p in sys.path])]
        _worker = os.getpid(), subprocess.Popen(
            line, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
        )  # fmt: skip
    return _worker[1]


atexit.register(stop)
