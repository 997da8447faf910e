"""What people read: text and tables that fit the terminal, plain where piped, and progress bars.

Piped output knows no width: lines are as long as they are, for `grep` and editors to deal with.
"""

import os
import sys
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any, TextIO

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions, RenderResult
    from rich.table import Table

    Tell = Callable[[str, float], None]

UNBOUNDED = 10_000
"""Width of what is no terminal."""

LINES_APART = 30.0
"""Least time [s] between lines on progress where no bar can be drawn, as in the log of a job."""

LONGEST_WORD = 24
"""Words longer than this may be broken in a table."""


def is_stdout(path: Path | None) -> bool:
    """Whether a path stands for standard output."""
    return path is not None and str(path) == "-"


def console(json_path: Path | None) -> "Console":
    """Where people read: stdout, or stderr where JSON goes to stdout.  Says text as it is, without markup."""
    from rich.console import Console

    from design.cli.terminal.plain import PlainHook
    from reports.shared.units import StreamInUnits

    stream = sys.stderr if is_stdout(json_path) else sys.stdout
    width = _width(stream)
    height = None if width is None else 25  # of no meaning, but rich takes both or none on a dumb terminal
    shown: Any = StreamInUnits(stream)
    made = Console(file=shown, width=width, height=height, highlight=False, markup=False, emoji=False)
    made.push_render_hook(PlainHook())  # type: ignore[arg-type]
    return made


def _width(stream: TextIO) -> int | None:
    """Columns to print in; None leaves it to rich, which asks the environment."""
    if "COLUMNS" in os.environ:
        return None
    if not stream.isatty():
        return UNBOUNDED
    return os.get_terminal_size(stream.fileno()).columns or None


@dataclass(frozen=True)
class Sheet:
    """A table that fits where it is printed.

    words: numbers of the columns that hold words, which stand left and may wrap; all others hold numbers,
    which stand right and never wrap.  Columns that have no room come below, after the first one again.
    """

    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    title: str = ""
    words: tuple[int, ...] = (0,)

    def __rich_console__(self, console: "Console", options: "ConsoleOptions") -> "RenderResult":
        from rich.text import Text

        if self.title:
            yield Text(self.title, style="bold")
        for number, columns in enumerate(self.parts(options.max_width)):
            if number:
                yield ""
            yield self._table(columns, options.max_width)

    def parts(self, width: int) -> list[list[int]]:
        """Columns of each part, the first column leading every one, that fit a width."""
        parts = [[0]]
        for i in range(1, len(self.headings)):
            if len(parts[-1]) > 1 and _total([self._narrowest(j) for j in (*parts[-1], i)]) > width:
                parts.append([0])
            parts[-1].append(i)
        return parts

    def _table(self, columns: list[int], width: int) -> "Table":
        from rich.table import Table

        gap = 2 if _total([self._narrowest(i) for i in columns], 2) <= width else 1
        widths = {i: self._widest(i) for i in columns}
        while _total(widths.values(), gap) > width:
            wide = [i for i in columns if widths[i] > self._narrowest(i)]
            if not wide:
                break
            widths[max(wide, key=lambda i: widths[i])] -= 1
        table = Table(box=None, pad_edge=False, padding=(0, gap, 0, 0))
        for i in columns:
            justify: Any = "left" if i in self.words else "right"
            table.add_column(
                self.headings[i],
                justify=justify,
                width=widths[i],
                no_wrap=i not in self.words,
                overflow="fold",
            )
        for row in self.rows:
            table.add_row(*(row[i] for i in columns))
        return table

    def _widest(self, column: int) -> int:
        return max(len(line) for line in chain.from_iterable(t.split("\n") for t in self._texts(column)))

    def _narrowest(self, column: int) -> int:
        """Least width: that of the numbers, or of the longest word."""
        if column not in self.words:
            return self._widest(column)
        words = chain.from_iterable(t.split() for t in self._texts(column))
        return min(LONGEST_WORD, max(map(len, words), default=1))

    def _texts(self, column: int) -> list[str]:
        return [self.headings[column], *(row[column] for row in self.rows)]


def _total(widths: Collection[int], gap: int = 1) -> int:
    """Width of columns with spaces between."""
    return sum(widths) + gap * (len(widths) - 1)


@contextmanager
def progress(what: str) -> Iterator["Tell"]:
    """A progress bar with the time left on stderr; yields what is told stage and share.  Where stderr is no
    terminal, a line for a new stage every `LINES_APART` s.

    A stage whose share is not known shows that something goes on, and for how long.  A share that is less
    than the one before begins anew; else stages go on where the one before ended.
    """
    if not sys.stderr.isatty() or os.environ.get("TERM") in ("dumb", "unknown"):
        yield _in_lines(what)
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, Task, TextColumn
    from rich.table import Column
    from rich.text import Text

    from design.cli.terminal.plain import plain

    shown = Console(stderr=True)
    bar_width = 20 if shown.width >= 80 else 10
    room = max(10, shown.width - bar_width - 20)  # of the words, beside the bar and the time

    class TimeLeft(TextColumn):
        def render(self, task: Task) -> Text:
            return Text(time_left(task.elapsed or 0.0, task.fields["told"], task.completed))

    columns = (
        TextColumn(
            "{task.description}", markup=False, table_column=Column(no_wrap=True, overflow="ellipsis")
        ),
        BarColumn(bar_width=bar_width),
        TimeLeft("", table_column=Column(no_wrap=True)),
    )
    with Progress(*columns, console=shown, transient=True, redirect_stdout=False) as bar:
        number = bar.add_task(plain(what), total=None, told=0.0)
        task = bar.tasks[0]

        def tell(stage: str, share: float) -> None:
            if share < task.completed or share <= 0.0:
                bar.reset(number, total=None)
            total = 1.0 if share > 0.0 else None  # without a total the bar pulses
            words, told = plain(f"{what}: {stage}"), task.elapsed or 0.0
            words = words if len(words) <= room else f"{words[: room - 1]}…"
            bar.update(number, description=words, completed=share, total=total, told=told)

        yield tell


def _in_lines(what: str) -> "Tell":
    """What says a new stage in a line on stderr, the last one long enough ago."""
    from design.cli.terminal.plain import plain

    said, before = monotonic(), ""

    def tell(stage: str, share: float) -> None:
        nonlocal said, before
        if stage != before and monotonic() - said > LINES_APART:
            print(plain(f"{what}: {stage}"), file=sys.stderr, flush=True)
            said, before = monotonic(), stage

    return tell


def time_left(elapsed: float, told: float, share: float) -> str:
    """The time that is left, by the share that was done when it was told, or, where that says nothing, the
    time that has gone by [s].

    >>> time_left(12.0, 10.0, 0.1)
    '1 min 28 s left'
    >>> time_left(12.0, 10.0, 0.9)
    '12 s'
    """
    left = told / share - elapsed if share > 0.0 else 0.0
    minutes, seconds = divmod(round(left if left > 0.0 else elapsed), 60)
    text = f"{minutes} min {seconds} s" if minutes else f"{seconds} s"
    return f"{text} left" if left > 0.0 else text
