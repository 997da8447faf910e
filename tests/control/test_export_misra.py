"""The exported C departs from MISRA C:2012 only as docs/targets.md lists."""

import os
import shutil
from collections import Counter
from dataclasses import replace

import pytest

from design.export import misra
from design.export.misra import DEVIATIONS, HEAD, HEADING, LAW, OWN, RuleBreach, found_in, row
from design.export.table import EXEMPLARY, exemplary
from plants import InputError
from tests.control.c_target import WRIST
from tests.control.test_export_table import table

needs_cppcheck = pytest.mark.skipif(shutil.which("cppcheck") is None, reason="no cppcheck on this machine")


@needs_cppcheck
@pytest.mark.parametrize(
    "kind", ["pi", *(pytest.param(k, marks=pytest.mark.suite) for k in EXEMPLARY if "mpc" in k)]
)
def test_nothing_is_found_that_is_not_listed(kind):
    found = found_in(exemplary(kind, WRIST))
    assert found.keys() - DEVIATIONS.keys() == set()
    assert found[RuleBreach("8.4", LAW)] >= 4  # its two laws and two helpers: the add-on ran


@needs_cppcheck
def test_what_is_not_listed_is_found():
    part = exemplary("pi", WRIST)
    bad = "int bad(int x);\nint bad(int x)\n{\n    if (x) {\n        x = 3;\n    }\n    return x;\n}\n"
    found = found_in(replace(part, code=part.code + bad))
    told = {RuleBreach(rule, LAW) for rule in ("14.4", "17.8")}
    assert found.keys() - DEVIATIONS.keys() >= told
    assert {row(finding, 1)[-1] for finding in told} == {"not listed"}


def test_the_page_lists_each_deviation_with_its_reason():
    head, *rows = table(HEADING)
    assert head == list(HEAD)
    assert [(r[0], r[2], r[1], r[4]) for r in rows] == [(*f, *d) for f, d in DEVIATIONS.items()]
    assert all(int(r[3]) >= 1 for r in rows)


def test_a_machine_without_cppcheck_is_told_what_to_install(monkeypatch):
    monkeypatch.setenv("PATH", "")
    with pytest.raises(InputError, match="apt-get install cppcheck"):
        found_in(exemplary("pi", WRIST))


@pytest.mark.parametrize("more", [{}, {RuleBreach("17.8", OWN): 2}])
def test_the_page_is_written_whole_and_what_is_not_listed_ends_with_an_error(more, monkeypatch):
    """Findings of all controllers are summed up, those without a reason stand last."""
    each, rows = {RuleBreach("8.4", LAW): 4, RuleBreach("2.5", OWN): 1, **more}, []
    monkeypatch.setattr(misra, "found_in", lambda part: Counter(each))
    monkeypatch.setattr(misra, "into_page", lambda prog, heading, head, told, words: rows.extend(told))
    if more:
        with pytest.raises(SystemExit) as ended:
            misra.main()
        assert ended.value.code == 1
    else:
        misra.main()
    n = len(EXEMPLARY)
    assert [r[:4] for r in rows[:2]] == [
        ["2.5", "advisory", OWN, f"{n}"],
        ["8.4", "required", LAW, f"{4 * n}"],
    ]
    assert [[r[0], *r[3:]] for r in rows[2:]] == [["17.8", f"{2 * n}", "not listed"] for _ in more]


def test_what_the_tool_prints_is_told_by_rule_and_by_whose_file_it_is(monkeypatch, tmp_path):
    """A stand-in for cppcheck that finds one thing in each of the files, and fails where it is told to."""
    part, tool = exemplary("pi", WRIST), tmp_path / "cppcheck"
    lines = [f"{part.name}.h:misra-c2012-2.5", f"{part.name}.c:unusedVariable"]
    lines += 2 * [f"{part.name}_law.c:misra-c2012-8.4"]
    tool.write_text("#!/bin/sh\n" + "".join(f"echo {line} >&2\n" for line in lines) + "exit ${FAILS:-0}\n")
    tool.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    assert found_in(part) == Counter(
        {RuleBreach("2.5", OWN): 1, RuleBreach("unusedVariable", OWN): 1, RuleBreach("8.4", LAW): 2}
    )
    monkeypatch.setenv("FAILS", "1")
    with pytest.raises(InputError, match=r"^cppcheck failed: "):
        found_in(part)
