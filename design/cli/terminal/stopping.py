"""Ctrl-C that stops at once, whatever the program is doing.

Python hears Ctrl-C between two of its own instructions: not while compiled code runs, not while it waits
at its end for threads, and some libraries swallow it.  So a thread of its own listens too, and ends the
process where the rest has not done so by itself within a moment.  Nothing half-written stays, since files
get their names when they are complete (`plants.files`).
"""

import os
import select
import signal
import sys
from threading import Event, Lock, Thread

STOPPED = 130
"""Exit code of a program that Ctrl-C has ended."""

GRACE = 0.5
"""Time [s] in which the program may put away what it was doing; a second Ctrl-C ends it at once."""


class Stop:
    """Whether Ctrl-C was pressed, and the way out, which is taken once."""

    def __init__(self) -> None:
        self._asked, self._leaving = Event(), Lock()

    @property
    def asked(self) -> bool:
        return self._asked.is_set()

    def leave(self) -> None:
        """End the process, without waiting for its threads."""
        if not self._leaving.acquire(blocking=False):
            Event().wait()  # the other thread is on its way out, and takes this one along
        show_cursor = "\r\x1b[2K\x1b[?25h" if os.isatty(2) and os.environ.get("TERM") != "dumb" else ""
        try:
            os.write(2, f"{show_cursor}wrist: stopped\n".encode())
            kernels = sys.modules.get("plants.kernel.cache")  # where it is not, there is nothing to remove
            if kernels is not None:
                kernels.remove_private()
        finally:
            os._exit(STOPPED)

    def listen(self, pipe: int) -> None:
        """Wait for the number of the signal in a pipe, then for its end."""
        while os.read(pipe, 1) != bytes([signal.SIGINT]):
            pass
        self._asked.set()
        select.select([pipe], [], [], GRACE)
        self.leave()


def hear_stop() -> Stop:
    """Listen for Ctrl-C in this process from now on; to be called by its main thread."""
    stop = Stop()
    if signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        return stop  # told to ignore it, as what runs behind nohup or & is
    heard, told = os.pipe()
    os.set_blocking(told, False)
    signal.set_wakeup_fd(told, warn_on_full_buffer=False)
    sys.unraisablehook = _quiet_about_stop
    Thread(target=stop.listen, args=(heard,), name="ctrl-c", daemon=True).start()
    return stop


def _quiet_about_stop(what: "sys.UnraisableHookArgs") -> None:
    """Ctrl-C within a destructor or a callback of compiled code is no news; all else is."""
    if what.exc_type is not KeyboardInterrupt:
        sys.__unraisablehook__(what)
