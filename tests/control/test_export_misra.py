"""The exported C departs from MISRA C:2012 only as docs/targets.md lists."""

import shutil
from dataclasses import replace

import pytest

from design.export.misra import DEVIATIONS, HEAD, HEADING, LAW, RuleBreach, found_in, row
from design.export.table import exemplary
from plants import InputError
from tests.control.c_target import WRIST
from tests.control.test_export_table import table

needs_cppcheck = pytest.mark.skipif(shutil.which("cppcheck") is None, reason="no cppcheck on this machine")


@needs_cppcheck
@pytest.mark.parametrize("kind", ["pi", pytest.param("mpc", marks=pytest.mark.suite)])
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
