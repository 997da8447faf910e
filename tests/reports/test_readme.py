"""What the README points at is there, what it shows runs, its figures are those of the committed report."""

import json
import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
EXAMPLE = json.loads((ROOT / "reports/examples/comparison.json").read_text(encoding="utf-8"))
BREAKS = {"overshoot_percent": "overshoot", "Ms": "Ms", "delay_margin_s": "delay margin"}


def test_every_file_that_it_links_to_is_in_the_project():
    links = re.findall(r"\]\(([^)#]+)[^)]*\)", README) + re.findall(r'src="([^"]+)"', README)
    links = [link for link in links if not link.startswith("http")]
    assert len(links) > 15
    assert [link for link in links if not (ROOT / link).is_file()] == []


@pytest.mark.filterwarnings("ignore")
def test_its_python_runs():
    blocks = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    assert len(blocks) == 1
    for code in blocks:
        exec(code, {})


def test_its_commands_are_there():
    from design.cli.app import MODULES

    named = set(re.findall(r"`wrist (\w+)", README))
    assert named == {m.NAME for m in MODULES}
    targets = set(re.findall(r"^(\w+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    assert set(re.findall(r"`make (\w+)", README)) <= targets
    for module in re.findall(r"python -m ([\w.]+)", README):
        place = ROOT / module.replace(".", "/")
        assert place.with_suffix(".py").is_file() or (place / "__main__.py").is_file()


def test_a_stranger_reads_it_in_two_minutes():
    assert len(README.splitlines()) <= 130
    prose = re.sub(r"```.*?```|\]\([^)]*\)", "", README, flags=re.DOTALL)
    assert len(prose.split()) < 1300


CALLED = {
    "recommended PI": "tuned", "paper's PI": "paper",
}  # fmt: skip


def test_its_table_of_controllers_is_the_committed_report():
    row = r"^\| (.+?) \| ([\d.]+) s \| ([\d.]+) % \| ([\d.]+|–) \| (.+?) \|$"
    rows = re.findall(row, README, re.MULTILINE)
    assert len(rows) == 10
    of = {s["controller"]: s for s in EXAMPLE["standings"] if s["motion"] == "flexion"}
    for name, settles, overshoot, Ms, breaks in rows:
        key = next((k for start, k in CALLED.items() if name.startswith(start)), name)
        s = of[key]
        assert float(settles) == pytest.approx(s["worst_settling_s"], abs=0.02), name
        assert float(overshoot) == pytest.approx(s["worst_overshoot_percent"], abs=0.15), name
        assert s["Ms"] is None if Ms == "–" else float(Ms) == pytest.approx(s["Ms"], abs=0.02), name
        assert breaks == (", ".join(BREAKS[b] for b in s["breaks"]) or "no"), name


def test_its_decision_is_the_committed_design():
    design = json.loads((ROOT / "reports/examples/design.json").read_text(encoding="utf-8"))
    row = r"^\| (\w+) \| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \| (\w+), ([\d.]+) 1/s \|$"
    rows = re.findall(row, README, re.MULTILINE)
    assert [r[0] for r in rows] == list(design["recommended"])
    for motion, Kp, Ki, b, cost, status, rate in rows:
        found = design["recommended"][motion]
        assert found["holds"]
        assert [float(v) for v in (Kp, Ki, b)] == [found["gains"][n] for n in ("Kp", "Ki", "b")]
        seen = found["evidence"]
        worst = max(seen[k]["worst_iae_deg_s"] for k in ("samples", "worst_case"))
        assert float(cost) == pytest.approx(worst, abs=0.006)
        proved = seen["proved"]
        assert (status, float(rate)) == (proved["status"], pytest.approx(proved["rate_1_s"], abs=6e-4))


def test_it_names_the_pythons_that_the_package_does():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    versions = [c.split("::")[-1].strip() for c in project["classifiers"]]
    assert f"Python {versions[0]} to {versions[-1]}" in README


@pytest.mark.slow
def test_the_committed_example_has_the_keys_of_today():
    from reports.comparison.record import comparison_record
    from reports.shared.html import Made
    from tests.reports.report_samples import small_study

    c = small_study()
    made = Made.now("wrist compare", sets=c.plants)
    ours = comparison_record(c, made)
    assert set(EXAMPLE) == set(ours)
    assert set(EXAMPLE["rows"][0]) == set(ours["rows"][0])
    given = {"given", "cases", "b", "Tf"}  # of gains that a design found, with two degrees of freedom
    assert set(EXAMPLE["tunings"]["flexion"]) - given == set(ours["tunings"]["flexion"])
