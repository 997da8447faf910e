"""Mutants are programs that differ by one fault, the same for the same seed."""

import ast
import json
import multiprocessing
import time
from pathlib import Path

import pytest

from tests.mutants.__main__ import ROOMS, ROOT, equivalents, files_of, sources, survivors
from tests.mutants.forked import Ended, followed
from tests.mutants.mutate import drawn, mutants
from tests.mutants.reach import Reached, chosen, enclosing, limits, naming, quickest, seen

TEXT = '''"""A law."""


def law(a: int, b: float = 0.0) -> float:
    """With 2 in its words."""
    if a < 1 and b > 2.0:
        raise ValueError(f"{a + 1} is too small")
    return a * b - max(a, 1)
'''


def test_each_is_a_program_with_one_line_changed(tmp_path):
    path = tmp_path / "law.py"
    path.write_text(TEXT)
    found = mutants(path)
    changed = {m.line for m in found}
    assert changed == {4, 6, 8}  # neither words nor messages nor annotations
    for m in found:
        assert ast.dump(ast.parse(m.text)) != ast.dump(ast.parse(TEXT))
        assert sum(a != b for a, b in zip(m.text.splitlines(), TEXT.splitlines(), strict=True)) == 1
    after = {m.after for m in found}
    assert "return (a / b) - max(a, 1)" in after
    assert "return a * b - (min(a, 1))" in after


def test_one_seed_is_as_good_as_another(tmp_path):
    path = tmp_path / "law.py"
    path.write_text(
        "def law(steps: int, seed: int = 0):\n    return np.random.default_rng((seed, 2)).random(3)\n"
    )
    assert {m.after for m in mutants(path)} == {
        f"return np.random.default_rng((seed, 2)).random(({n}))" for n in (4, 5)
    }


@pytest.mark.slow
def test_a_seed_draws_the_same():
    files = sources("export")
    assert drawn(files, 5, 3) == drawn(files, 5, 3) != drawn(files, 5, 4)


def test_a_room_has_all_tests_that_import_its_modules():
    of_certificates, of_laws = "tests/robustness/test_robust_mpc.py", "tests/laws/test_signals.py"
    assert {of_certificates, of_laws} <= set(files_of("kernels"))
    assert of_laws not in files_of("certificates")
    assert "tests/measured/test_sign_of_a_log.py" in files_of("export")


def test_survivors_of_an_earlier_run_are_found_again_on_another_line(tmp_path):
    one, other, third = drawn(sources("export"), 3, 3)
    records = [
        {"room": room, "ended": ended, "place": f"{m.path.relative_to(ROOT)}:{m.line + 7}", "after": m.after}
        for m, room, ended in (
            (one, "export", "survived"),
            (other, "export", "caught"),
            (third, "laws", "survived"),
        )
    ]
    kept = tmp_path / "mutants.json"
    kept.write_text(json.dumps({"seed": 3, "mutants": records}))
    assert one in survivors("export", kept)
    assert {m.after for m in survivors("export", kept)} == {one.after}


@pytest.mark.slow
def test_each_that_changes_nothing_is_one_and_says_why():
    of_rooms = {str(p.relative_to(ROOT)): p for room in ROOMS for p in sources(room)}
    stated: dict[str, set[str]] = {}
    for known in equivalents():
        stated.setdefault(known["path"], set()).add(known["after"])
        assert len(known["reason"]) > 20
    for path, lines in stated.items():
        assert {m.after for m in mutants(of_rooms[path], lines)} == lines, path


NESTED = """
LIMIT = 1

class Law:
    most: float = 2.0

    def step(self, x):
        def inner(y):
            return y + 1
        return inner(x)
"""


def test_a_line_lies_in_functions_named_as_python_names_them():
    made: dict = {}
    exec(NESTED, made)
    step = made["Law"].step.__code__
    (inner,) = (c for c in step.co_consts if hasattr(c, "co_qualname"))
    assert enclosing(NESTED, "a.py", 9) == [f"a.py::{inner.co_qualname}", f"a.py::{step.co_qualname}"]
    assert enclosing(NESTED, "a.py", 10) == [f"a.py::{step.co_qualname}"]
    assert enclosing(NESTED, "a.py", 5) == enclosing(NESTED, "a.py", 2) == []


REACHED = {
    "one.py::slow": Reached(9.0, frozenset({"a.py::f", "a.py::g"})),
    "one.py::quick": Reached(1.0, frozenset({"a.py::f"})),
    "one.py::beside": Reached(0.1, frozenset()),
    "two.py::far": Reached(0.2, frozenset({"b.py::h"})),
}


def test_tests_that_reach_it_come_first_and_the_quick_ones_of_them():
    assert chosen(REACHED, ["a.py::f"], "a.py", 99.0) == ["one.py::quick", "one.py::slow", "one.py::beside"]
    assert chosen(REACHED, ["a.py::f"], "a.py", 5.0) == ["one.py::quick"]
    assert chosen(REACHED, ["a.py::unseen", "a.py::g"], "a.py", 99.0)[0] == "one.py::slow"
    assert chosen(REACHED, [], "b.py", 99.0) == ["two.py::far"]


def test_files_that_name_the_function_come_before_those_that_name_its_module_alone(tmp_path):
    (tmp_path / "room").mkdir()
    (tmp_path / "room" / "law.py").write_text("def _inner():\n    return 1\n")
    texts = {"a": "from room import law", "b": "from room.law import _inner", "c": "import other"}
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    path = Path("room/law.py")
    assert naming(tmp_path, texts, path, ["room/law.py::_inner"]) == ["b", "a"]
    assert naming(tmp_path, texts, path) == ["a", "b"]


def test_no_test_is_seen_to_call_what_is_called_on_import_alone():
    assert seen(REACHED, ["a.py::on_import", "a.py::g"])
    assert not seen(REACHED, ["a.py::on_import"])
    assert not seen(REACHED, [])


def test_of_all_tests_the_quick_ones():
    assert quickest(REACHED, 1.5) == ["one.py::beside", "two.py::far", "one.py::quick"]


def test_a_test_hangs_beyond_five_times_the_longest_of_its_file_and_a_minute():
    assert limits(REACHED) == {
        "one.py::slow": 105.0, "one.py::quick": 105.0, "one.py::beside": 105.0, "two.py::far": 61.0
    }  # fmt: skip


@pytest.mark.parametrize(
    ("said", "seconds", "ended"),
    [
        (["one.py::quick", (1, "one.py::quick")], 99.0, Ended(1, "one.py::quick")),
        (["one.py::quick", "one.py::slow"], 99.0, Ended(None, "one.py::slow")),
        (["one.py::slow", "one.py::quick"], 0.01, Ended(None, None)),
        (["one.py::unknown"], 0.01, Ended(None, None)),
    ],
)
def test_a_run_is_out_of_time_and_names_the_test_that_hangs(said, seconds, ended):
    receiver, sender = multiprocessing.Pipe(duplex=False)
    for message in said:
        sender.send(message)
    limit = {"one.py::quick": 9.0, "one.py::slow": 0.01}
    assert followed(receiver, time.monotonic() + seconds, limit) == ended
