"""A table holds every cell in every width: numbers whole, words between their spaces."""

import re
from io import StringIO

import pytest
from rich.console import Console

from design.cli.terminal import screen
from design.cli.terminal.screen import Sheet

HEADINGS = ("controller", "Kp", "settle\n/bound", "what it says", "IAE\ndeg s")
ROWS = (
    ("convex-concave PI", "3.71", "13.7 ", "settles later than any other", "9.26"),
    ("paper", "1.2", "-12345.678▲", "stands in for [the] one that is lost", "1.17e-05"),
)
SHEET = Sheet(HEADINGS, ROWS, "flexion: a title that is much longer than the table", words=(0, 3))


def shown(width: int) -> str:
    file = StringIO()
    Console(file=file, width=width, markup=False, highlight=False).print(SHEET)
    return file.getvalue()


@pytest.mark.parametrize("width", [34, 40, 52, 60, 80, 200])
def test_every_number_is_whole_and_every_word_is_there(width):
    text = shown(width)
    assert max(map(len, text.splitlines())) <= width
    assert "…" not in text
    for row in ROWS:
        for i in (1, 2, 4):
            assert re.search(rf"(^|\s){re.escape(row[i].strip())}(\s|$)", text, re.M)
        assert set(row[3].split()) <= set(text.split())


def test_columns_without_room_come_below_after_the_first_again():
    assert SHEET.parts(200) == [[0, 1, 2, 3, 4]]
    narrow = SHEET.parts(34)
    assert all(part[0] == 0 for part in narrow)
    assert [i for part in narrow for i in part[1:]] == [1, 2, 3, 4]
    assert len(narrow) > 1


def test_where_there_is_room_a_row_is_a_line():
    assert len(shown(200).splitlines()) == 1 + 2 + len(ROWS)


def test_progress_is_told_in_lines_where_there_is_no_terminal(capsys, monkeypatch):
    now = iter([0.0, 10.0, 31.0, 31.0, 62.0, 90.0, 90.0])
    monkeypatch.setattr(screen, "monotonic", lambda: next(now))
    with screen.progress("design") as tell:
        tell("corners", 0.1)  # 10 s: too early
        tell("corners", 0.2)  # 31 s
        tell("corners", 0.3)  # the same
        tell("samples", 0.4)  # 62 s
    assert capsys.readouterr().err == "design: corners\ndesign: samples\n"
