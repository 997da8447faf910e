"""pytest in a forked process, so that what others wrote is loaded once for hundreds of runs."""

import importlib
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Callable, Mapping
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, NamedTuple

OURS = ("plants", "design", "reports", "tests")
HEAVY = (
    "numpy", "scipy.stats", "scipy.signal", "scipy.optimize", "casadi", "numba", "control", "cvxpy",
    "pandas", "sklearn", "matplotlib.pyplot", "hypothesis", "daqp", "pytest",
)  # fmt: skip
MEMORY = 8 << 30
"""Bytes that a run may take: a fault in a size shall not take the machine's."""


class Ended(NamedTuple):
    """How a run ended: pytest's exit code, None where time was out, -1 where the process died; and what its
    plugin had found, where time was out the test that took longer than its own limit."""

    code: int | None
    found: Any


def prepare(cache: Path) -> None:
    """Load what every run needs; compiled kernels go to a cache that begins with what is in the user's."""
    import platformdirs

    kept = Path(platformdirs.user_cache_dir("wrist")) / "kernels"
    made = cache / "wrist" / "kernels"
    made.mkdir(parents=True, mode=0o700)
    made.parent.chmod(0o700)
    for path in kept.glob("*.kernel"):
        try:
            os.link(path, made / path.name)
        except OSError:  # of another file system
            (made / path.name).write_bytes(path.read_bytes())
    os.environ |= {
        "XDG_CACHE_HOME": str(cache), "MPLBACKEND": "Agg", "OPENBLAS_NUM_THREADS": "1",
        "PYTHONDONTWRITEBYTECODE": "1",
    }  # fmt: skip
    for name in HEAVY:
        importlib.import_module(name)


def pytest_forked(
    copy: Path,
    words: list[str],
    plugin: Callable[[], Any],
    timeout: float,
    limits: Mapping[str, float] | None = None,
) -> Ended:
    """Run pytest in a copy of the project with a plugin, whose ``found`` comes back.

    Time is out after ``timeout`` [s], or where a test takes longer than its own of ``limits`` [s]."""
    forked = multiprocessing.get_context("fork")
    receiver, sender = forked.Pipe(duplex=False)
    process = forked.Process(target=_child, args=(copy, words, plugin, sender))
    process.start()
    sender.close()
    try:
        return followed(receiver, time.monotonic() + timeout, limits or {})
    except EOFError:
        return Ended(-1, None)
    finally:
        _end(process.pid)
        process.join()


def followed(receiver: Connection, end: float, limits: Mapping[str, float]) -> Ended:
    """What a run says last; before that it says which test begins."""
    test, until = "", end
    while receiver.poll(max(0.0, min(until, end) - time.monotonic())):
        said = receiver.recv()
        if not isinstance(said, str):
            return Ended(*said)
        test, until = said, time.monotonic() + limits.get(said, float("inf"))
    return Ended(None, test if until < end else None)


class _Began:
    """A plugin that says which test begins."""

    def __init__(self, sender: Connection) -> None:
        self.sender = sender

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        self.sender.send(nodeid)


def _end(pid: int | None) -> None:
    """The process and all that it started, which are a group of their own."""
    assert pid is not None
    try:
        os.killpg(pid, signal.SIGKILL)
    except ProcessLookupError:  # not yet a group, or ended
        try:
            os.kill(pid, signal.SIGKILL)
        except ProcessLookupError:
            return


def _child(copy: Path, words: list[str], plugin: Callable[[], Any], sender: Connection) -> None:
    import resource

    import pytest

    os.setsid()
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    null = os.open(os.devnull, os.O_RDWR)
    for standard in (0, 1, 2):
        os.dup2(null, standard)
    os.chdir(copy)
    os.environ["PYTHONPATH"] = str(copy)
    for name in [n for n in sys.modules if n.partition(".")[0] in OURS]:
        del sys.modules[name]
    sys.path[:] = [str(copy), *(p for p in sys.path if p and Path(p).resolve() != copy)]
    found = plugin()
    loaded = ("-W", "ignore::pytest.PytestAssertRewriteWarning")  # before pytest could rewrite it
    code = pytest.main(
        ["-q", "-m", "not suite", "-p", "no:cacheprovider", *loaded, *words], plugins=[found, _Began(sender)]
    )
    sender.send((int(code), found.found))
