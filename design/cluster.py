"""One function over many pieces: in threads of this process, or on a Dask cluster that is there already.

What a piece gives depends on the piece alone, and results are put together in the order of the
pieces: the same for any number of threads or workers, whichever finishes first.
"""

import re
import socket
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from typing import Any, TypeVar

from plants.errors import InputError

Piece = TypeVar("Piece")
Result = TypeVar("Result")

REACHED_WITHIN = 5.0
"""Time [s] within which a scheduler must answer, and have a worker."""


def each(
    function: Callable[[Piece], Result],
    pieces: Sequence[Piece],
    scheduler: str | None = None,
    progress: Callable[[float], None] | None = None,
    jobs: int = 1,
) -> list[Result]:
    """``function(piece)`` of every piece, in the order of the pieces.

    `scheduler`: address of a Dask scheduler, such as ``tcp://host:8786``, whose workers must have this
    package; here, in `jobs` threads, where None.  `progress` is told the share of the pieces that is
    done.  A worker that dies costs time only: the scheduler has its pieces done again by others, up
    to its setting ``distributed.scheduler.allowed-failures``.  Raises InputError for a scheduler that
    cannot be reached or has no workers, a piece at which worker after worker dies, and where
    ``distributed`` is not installed; and what `function` raises.

    >>> each(abs, [-1, 2, -3], jobs=2)
    [1, 2, 3]
    """
    tell = progress or (lambda share: None)
    if scheduler is not None:
        return _on_cluster(function, pieces, scheduler, tell)
    if min(jobs, len(pieces)) > 1:
        return _in_threads(function, pieces, jobs, tell)
    done = []
    for number, piece in enumerate(pieces):
        done.append(function(piece))
        tell((number + 1) / len(pieces))
    return done


def _in_threads(
    function: Callable[[Piece], Result], pieces: Sequence[Piece], jobs: int, tell: Callable[[float], None]
) -> list[Result]:
    with ThreadPoolExecutor(min(jobs, len(pieces)), thread_name_prefix="pieces") as pool:
        futures = [pool.submit(function, piece) for piece in pieces]
        left = set(futures)
        try:
            while left:
                finished, left = wait(left, return_when=FIRST_COMPLETED)
                for future in finished:
                    future.result()  # raises what the piece did
                tell(1.0 - len(left) / len(pieces))
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
    return [future.result() for future in futures]


def _on_cluster(
    function: Callable[[Piece], Result],
    pieces: Sequence[Piece],
    address: str,
    tell: Callable[[float], None],
) -> list[Result]:
    distributed = _distributed()
    client = _client(distributed, address)
    try:
        # Keys of their own for every call: what another version of the code left on the cluster, or
        # equal pieces of another job, must not pass for results of this one.
        futures = client.map(function, pieces, pure=False)
        place = {future.key: number for number, future in enumerate(futures)}
        found: dict[int, Result] = {}
        for future, value in distributed.as_completed(futures, client.loop, with_results=True):
            if future.cancelled():  # the scheduler forgot it, for it went away
                raise InputError(f"scheduler {address}: went away before all was done; start it again")
            found[place[future.key]] = value  # by place: a piece that was done twice counts once
            future.release()
            tell(len(found) / len(pieces))
        return [found[number] for number in range(len(pieces))]
    except distributed.KilledWorker:
        raise InputError(
            f"scheduler {address}: worker after worker died at the same piece; give them more memory"
        ) from None
    finally:
        client.close()


def _distributed() -> Any:
    """The package, which takes half a second to import and need not be there."""
    try:
        import distributed
    except ImportError:
        raise InputError(
            'a scheduler needs the package distributed; pip install "wrist-workbench[cluster]"'
        ) from None
    return distributed


def _client(distributed: Any, address: str) -> Any:
    """A client of the scheduler at an address that has a worker."""
    help_ = "start one with `dask scheduler` and `dask worker ADDRESS`, and give its tcp://host:port"
    found = re.fullmatch(r"(?:(\w+)://)?([\w.-]+|\[[0-9a-fA-F:]+\]):(\d{1,5})", address)
    if (
        found is None
        or not 0 < int(found[3]) < 65536
        or (found[1] or "tcp") not in ("tcp", "tls", "ws", "wss")
    ):
        raise InputError(f"scheduler {address}: cannot be reached (no address); {help_}")
    try:  # a client of a scheduler that is not there takes its time, and says so in tracebacks
        socket.create_connection((found[2].strip("[]"), int(found[3])), timeout=REACHED_WITHIN).close()
    except OSError as why:
        raise InputError(f"scheduler {address}: cannot be reached ({type(why).__name__}); {help_}") from None
    try:
        client = distributed.Client(address, timeout=REACHED_WITHIN, set_as_default=False)
    except (OSError, TimeoutError, ValueError, RuntimeError) as why:
        raise InputError(f"scheduler {address}: cannot be reached ({type(why).__name__}); {help_}") from None
    try:
        client.wait_for_workers(1, timeout=REACHED_WITHIN)
    except TimeoutError:
        client.close()
        raise InputError(f"scheduler {address}: has no workers; {help_}") from None
    return client
