"""Output whose reader may go away before all is said, as ``| head`` does: the work goes on and writes its
files, what nobody reads is dropped."""

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from io import TextIOWrapper
from typing import Any, TextIO


class Outliving:
    """A stream that goes on as nothing when it breaks; `broken` says why, None where its reader just left."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self.broken: OSError | None = None

    def write(self, text: str) -> int:
        try:
            return self._stream.write(text)
        except OSError as why:
            self._break(why)
            return len(text)

    def flush(self) -> None:
        try:
            self._stream.flush()
        except OSError as why:
            self._break(why)

    def _break(self, why: OSError) -> None:
        if not isinstance(why, BrokenPipeError):
            self.broken = why
        nowhere = os.open(os.devnull, os.O_WRONLY)  # takes what is still in the stream's buffer, too
        os.dup2(nowhere, self._stream.fileno())
        os.close(nowhere)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


@contextmanager
def outliving() -> Iterator[Callable[[], bool]]:
    """Make stdout and stderr outlive their readers; yields whether output was lost, and says so.

    A process that was started without them writes to nowhere.
    """
    with open(os.devnull, "w") as nowhere:
        for stream in (sys.stdout, sys.stderr):
            if isinstance(stream, TextIOWrapper):  # a letter that the encoding lacks is no reason to stop
                stream.reconfigure(errors="replace")
        out, err = Outliving(sys.stdout or nowhere), Outliving(sys.stderr or nowhere)

        def lost() -> bool:
            out.flush()
            if out.broken is not None:
                err.write(f"wrist: stdout cannot be written ({out.broken.strerror}); the rest is done\n")
            err.flush()
            return out.broken is not None

        with redirect_stdout(out), redirect_stderr(err):
            yield lost
