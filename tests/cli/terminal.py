"""``wrist`` as a process of its own: with pipes, or on a pseudo-terminal of a given width."""

import fcntl
import os
import pty
import re
import select
import signal
import struct
import subprocess
import sys
import termios
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

COMMAND = [sys.executable, "-m", "design.cli"]
ROOT = Path(__file__).parents[2]
PATIENCE = 120.0
"""Time [s] after which a test gives up; no claim about speed."""


def environment(**more: str) -> dict[str, str]:
    """This one without what says how terminals are to be treated, so that a CI's own words do not matter."""
    said = {"NO_COLOR", "FORCE_COLOR", "PY_COLORS", "GITHUB_ACTIONS", "COLUMNS", "LINES", "TTY_COMPATIBLE"}
    kept = {k: v for k, v in os.environ.items() if k not in said}
    return {**kept, "PYTHONPATH": str(ROOT), "TERM": "xterm-256color", **more}


def piped(*arguments: object, **more: str) -> subprocess.CompletedProcess[str]:
    """Run to the end with stdout and stderr in pipes."""
    words = [str(a) for a in arguments]
    return subprocess.run(
        COMMAND + words, capture_output=True, text=True, timeout=PATIENCE, env=environment(**more)
    )


class Seen(NamedTuple):
    """What came on the terminal, with its control sequences; what came through the pipe on stdout, if it
    was one; the exit code, and how long the process lived after `type_after` was met."""

    screen: str
    out: str
    code: int
    lasted: float

    @property
    def lines(self) -> list[str]:
        """The lines of the screen without colours."""
        return [re.sub(r"\x1b\[[\d;?]*[A-Za-z]", "", line) for line in self.screen.splitlines()]


def _as_in_a_shell() -> None:
    """In the new process: the terminal is its own, and Ctrl-C is heard, which a CI that runs its jobs in the
    background has told all that it starts to ignore."""
    fcntl.ioctl(0, termios.TIOCSCTTY, 0)
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def on_terminal(
    *arguments: object,
    columns: int = 80,
    stdout: Path | None = None,
    press: tuple[str, Callable[[str], bool]] | None = None,
    command: list[str] = COMMAND,
    **more: str,
) -> Seen:
    """Run on a terminal of its own; stdout: a file in its place; press: keys, and on which screen."""
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 40, columns, 0, 0))
    with open(stdout or os.devnull, "wb") as file:
        process = subprocess.Popen(
            command + [str(a) for a in arguments],
            stdin=theirs, stdout=theirs if stdout is None else file, stderr=theirs,
            start_new_session=True, env=environment(**more),
            preexec_fn=_as_in_a_shell,
        )  # fmt: skip
    os.close(theirs)
    screen, pressed, begun = "", 0.0, time.monotonic()
    try:
        while True:
            if select.select([ours], [], [], 0.02)[0]:
                try:
                    some = os.read(ours, 65536)
                except OSError:  # Linux: nobody has the other end any more
                    some = b""
                screen += some.decode(errors="replace")
                if not some:
                    break
            if press is not None and not pressed and press[1](screen):
                os.write(ours, press[0].encode())
                pressed = time.monotonic()
            assert time.monotonic() - begun < PATIENCE, screen
        code = process.wait(PATIENCE)
    finally:
        process.kill()
        process.wait()
        os.close(ours)
    said = stdout.read_text() if stdout is not None else ""
    return Seen(screen, said, code, time.monotonic() - pressed if pressed else 0.0)
