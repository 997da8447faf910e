"""What the README points at is there, and what it shows runs."""

import json
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_every_file_that_it_links_to_is_in_the_project():
    links = [link for link in re.findall(r"\]\(([^)]+)\)", README) if not link.startswith("http")]
    assert links
    assert [link for link in links if not (ROOT / link).is_file()] == []


@pytest.mark.filterwarnings("ignore")
def test_its_python_runs():
    blocks = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    assert len(blocks) == 3
    for code in blocks:
        exec(code, {"plants": __import__("plants")})  # `plants` was imported in the block before


def test_the_committed_example_has_the_keys_of_today():
    from report_samples import compare_both

    from reports.html import Made
    from reports.records import comparison_record

    c = compare_both()
    made = Made.now("wrist compare", sets=c.sets)
    ours = comparison_record(c.comparison, c.tunings, c.sets, c.fits, made)
    example = json.loads((ROOT / "reports/examples/comparison.json").read_text(encoding="utf-8"))
    assert set(example) == set(ours)
    assert set(example["rows"][0]) == set(ours["rows"][0])
    assert set(example["tunings"]["flexion"]) == set(ours["tunings"]["flexion"])
    assert set(example["fits"]["flexion"]) == set(ours["fits"]["flexion"])
