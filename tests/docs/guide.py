"""A guide, followed to the letter: its files are written, its edits made, its code and commands run.

What a block of a guide is, by its language and its first line:

    any language, first line ``# PATH``   a file to write, PATH from the folder the reader works in
    ``diff``, first line ``--- PATH``     an edit of that file: the lines without ``+`` are there, side by
                                          side, and those with it come between them
    ``python``                            code to run, its names kept for the blocks after it
    ``sh``                                commands; those that begin with ``wrist`` are run
    ``text``                              what the block before it prints, ``...`` for lines left out
"""

import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.DOTALL | re.MULTILINE)


@dataclass(frozen=True)
class Block:
    """A block of code of a guide, and the line of the guide that it begins on."""

    language: str
    text: str
    line: int

    @property
    def path(self) -> str | None:
        """The file that the block is, if it is one."""
        first = re.match(r"# (\S+/\S+|\S+\.toml)\n", self.text)
        return first[1] if first and self.language != "sh" else None


def blocks(guide: Path) -> list[Block]:
    """The blocks of a guide, in order."""
    text = guide.read_text(encoding="utf-8")
    return [Block(m[1], m[2], text[: m.start()].count("\n") + 1) for m in BLOCK.finditer(text)]


def write(block: Block, folder: Path) -> Path:
    """Write the file that a block is."""
    assert block.path
    path = folder / block.path
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(block.text.split("\n", 1)[1], encoding="utf-8")
    return path


def edit(block: Block, folder: Path) -> None:
    """Make the edit that a ``diff`` block is; its untouched lines must stand in the file, once."""
    head, *lines = block.text.splitlines()
    path = folder / head.removeprefix("--- ")
    before = path.read_text(encoding="utf-8")
    old = "".join(f"{line[1:]}\n" for line in lines if line[0] != "+")
    assert before.count(old) == 1, f"line {block.line}: {old!r} stands {before.count(old)} times in {path}"
    path.write_text(before.replace(old, "".join(f"{line[1:]}\n" for line in lines)), encoding="utf-8")


def commands(block: Block) -> list[list[str]]:
    """Arguments of the ``wrist`` commands of a ``sh`` block; a line may go on after a backslash."""
    lines = block.text.replace("\\\n", " ").splitlines()
    return [line.split()[1:] for line in lines if line.startswith("wrist ")]


def missing(shown: str, printed: str, tolerance: float = 0.05) -> list[str]:
    """Lines of a ``text`` block that were not printed, in their order; spaces do not count, and numbers
    need to agree within a share of them, since fits end elsewhere on other machines."""
    wanted = [line for line in shown.splitlines() if line.strip() not in ("", "...")]
    rest = printed.splitlines()
    for line in wanted:
        at = next((i for i, there in enumerate(rest) if _alike(line, there, tolerance)), None)
        if at is None:
            return [line]
        rest = rest[at + 1 :]
    return []


def _alike(shown: str, printed: str, tolerance: float) -> bool:
    ours, theirs = (NUMBER.sub("#", " ".join(s.split())) for s in (shown, printed))
    if ours != theirs:
        return False
    pairs = zip(NUMBER.findall(shown), NUMBER.findall(printed), strict=True)
    return all(abs(float(a) - float(b)) <= tolerance * max(abs(float(a)), abs(float(b))) for a, b in pairs)
