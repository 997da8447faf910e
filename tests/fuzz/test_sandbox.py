"""A try that does harm is seen: what counts nothing would always find nothing."""

import pytest

from plants.errors import InputError
from tests.fuzz.sandbox import HALF, LINES, OUTSIDE, SILENT, TRACEBACK, Sandbox


def refuse(words):
    raise InputError(words)


HARM = {
    TRACEBACK: lambda box: {}["nothing"],
    OUTSIDE: lambda box: (box.out.parent.parent / "evil").write_text("x"),
    HALF: lambda box: (box.out / "a.json").write_text('{"a": '),
    LINES: lambda box: refuse("two\nlines"),
    SILENT: lambda box: None,
}


@pytest.mark.parametrize("fault", HARM)
def test_harm_is_counted(tmp_path, fault):
    box = Sandbox(tmp_path / "box")
    with box.fresh():
        assert box.call(lambda: HARM[fault](box), must_refuse=fault == SILENT).faults == (fault,)


@pytest.mark.parametrize(
    ("name", "content"), [(".wrist-h-1-x", b""), ("a.png", b"\x89PNG"), ("a.toml", b"x = ")]
)
def test_a_file_that_is_not_whole_is_seen(tmp_path, name, content):
    box = Sandbox(tmp_path / "box")
    with box.fresh():
        assert box.call(lambda: (box.out / name).write_bytes(content)).faults == (HALF,)


def test_a_refusal_is_no_fault(tmp_path):
    box = Sandbox(tmp_path / "box")
    with box.fresh():
        outcome = box.call(lambda: refuse("no"), must_refuse=True)
        told = box.wrist(["simulate", "--volts", "nan"], must_refuse=True)
    assert (outcome.code, outcome.faults, told.code, told.faults) == (2, (), 2, ())


def test_an_escape_is_seen(tmp_path):
    box = Sandbox(tmp_path / "box")
    with box.fresh():
        assert box.call(lambda: print("\x1b[2J")).faults == (LINES,)
