"""The page on tuning for python-control runs, and its loops hold what it asks."""

import re

import pytest

from tests.docs.guide import DOCS


@pytest.mark.slow
def test_the_page_runs_and_holds_its_limits(capsys):
    text = (DOCS / "tune-a-pi.md").read_text(encoding="utf-8")
    code = re.search(r"```python\n(.*?)```", text, re.DOTALL)[1]
    scope = {}
    exec(code, scope)
    said = capsys.readouterr().out
    assert said.count("stable: True") == 2
    for held in scope["found"].margins:
        assert held.Ms <= 1.7
        assert held.phase_margin_deg >= 50.0
        assert held.delay_margin_s > 0.02
