"""Text that a terminal shows and does not obey: titles, names and paths come from files of others."""

import re
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions, RenderResult

# Control characters but for line breaks and tabs; what turns the direction of writing; line separators.
_OBEYED = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u2028\u2029\u202a-\u202e\u2066-\u2069]")


def plain(text: str) -> str:
    """A text whose control characters are written out.

    >>> plain("a title\\x1b[2J")
    'a title\\\\x1b[2J'
    """
    return _OBEYED.sub(lambda m: m[0].encode("unicode_escape").decode(), text)


class PlainHook:
    """For a console: whatever is printed is shown plainly, in the console's own colours."""

    def process_renderables(self, renderables: list[Any]) -> list[Any]:
        """What `rich` asks of a hook."""
        return [_Plain(r) for r in renderables]


class _Plain:
    def __init__(self, inner: Any) -> None:
        self.inner = inner

    def __rich_console__(self, console: "Console", options: "ConsoleOptions") -> "RenderResult":
        from rich.segment import Segment

        for s in console.render(self.inner, options):
            yield s if s.control else Segment(plain(s.text), s.style)
