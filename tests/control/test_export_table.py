"""The tables of docs/targets.md: of the controllers that the command knows, of what ran, in their place."""

import re
from dataclasses import replace

import pytest

from design.export.plant import __main__ as plant_page
from design.export.plant.__main__ import HEAD as PLANT_HEAD
from design.export.plant.__main__ import HEADING as PLANT_HEADING
from design.export.plant.__main__ import plant_row, showing
from design.export.plant.files import plant_part
from design.export.table import (
    EXEMPLARY,
    HEAD,
    HEADING,
    HEADING_OF_PLAYS,
    difference_in_c,
    difference_in_unit,
    exemplary,
    into_page,
    of_plays,
    replaced,
    row,
)
from design.export.vectors import vector
from plants import InputError
from plants.effects import EFFECTS
from plants.effects.wrist.load_step import LoadStep
from tests.control.c_target import WRIST, needs_compiler
from tests.docs.guide import DOCS

PAGE = (DOCS / "targets.md").read_text(encoding="utf-8")


def table(heading):
    """Cells of the first table under a heading, its head first."""
    rows = re.search(r"(?:^\|.*\|\n)+", PAGE.split(heading + "\n")[1], re.MULTILINE)[0]
    lines = re.findall(r"^\| (.*) \|$", rows, re.MULTILINE)
    return [line.split(" | ") for line in lines if not line.startswith("---")]


@pytest.mark.slow
@pytest.mark.parametrize("heading", [HEADING, HEADING_OF_PLAYS])
def test_the_page_has_a_row_for_each_controller_of_the_catalogue(heading):
    head, *rows = table(heading)
    assert head == list(HEAD)
    assert [cells[:2] for cells in rows] == [[kind, exemplary(kind, WRIST).output.unit] for kind in EXEMPLARY]
    for kind, _, *found in rows:
        double, single, *units = map(float, found)
        assert max(double, *units) < exemplary(kind, WRIST).tolerance
        assert double < single < exemplary(kind, WRIST).at("single").tolerance


def test_the_page_has_a_row_for_each_effect_of_a_plant():
    head, *rows = table(PLANT_HEADING)
    assert head == list(PLANT_HEAD)
    own = {name: str(len(forms)) for name, forms in EFFECTS.items()}
    assert {label: forms for label, forms, *_ in rows[2:]} == own
    for label, _, *found in rows:
        differences = [float(x) for cell in found for x in cell.split(", ")]
        assert len(differences) == 6
        assert max(differences) < min(plant_part("flexion", WRIST).tolerance), label


@needs_compiler
def test_a_row_of_a_plant_is_what_the_targets_did():
    pytest.importorskip("fmpy")
    label, forms, *found = plant_row("of plays", [of_plays(WRIST)], 300)
    assert (label, forms) == ("of plays", "1")
    assert max(float(x) for cell in found for x in cell.split(", ")) < 1e-11


def test_a_row_of_several_plants_has_the_largest_difference_of_any(monkeypatch):
    """Of angle and pressure each, in C and in a unit of either version."""
    of = {
        "one": [(1e-9, 2e-8), (3e-9, 4e-8), (7e-9, 6e-8)],
        "other": [(5e-9, 1e-8), (2e-9, 8e-8), (6e-9, 9e-8)],
    }
    monkeypatch.setattr(plant_page, "plant_differences", lambda wrist, steps: of[wrist])
    cells = ["5e-09", "2e-08", "3e-09, 8e-08", "7e-09, 9e-08"]
    assert plant_row("creep", of, 300) == ["creep", "2", *cells]


def test_an_effect_that_does_not_show_is_not_compared():
    with pytest.raises(InputError, match="no trial of it shows in 100 samples"):
        showing(LoadStep, WRIST, 100)


@needs_compiler
def test_a_row_is_what_the_targets_did():
    pytest.importorskip("fmpy")
    kind, unit, *found = row("lqi", WRIST, 300)
    assert (kind, unit) == ("lqi", "V")
    double, single, *units = map(float, found)
    assert max(double, *units) < 1e-12 < single < 1e-3


@needs_compiler
def test_a_target_that_answers_otherwise_is_seen():
    pytest.importorskip("fmpy")
    part = exemplary("pi", WRIST)
    found = vector(part, WRIST, 200)
    rows = found.rows.copy()
    rows[150, 3] += 0.25
    other = found._replace(rows=rows)
    assert difference_in_c(part, other) == pytest.approx(0.25)
    assert difference_in_unit(part, other, "3.0") == pytest.approx(0.25)
    with pytest.raises(RuntimeError, match="error"):
        difference_in_c(replace(part, code="no C"), found)


def test_a_page_without_a_place_for_the_table_is_refused():
    with pytest.raises(InputError, match="no table under '## B'"):
        replaced("## A\n| x |\n", "## B", "| y |")
    with pytest.raises(InputError, match="no table under '## B'"):
        replaced("## B\nwords\n\n## A\n| x |\n", "## B", "| y |")


def test_a_table_takes_the_place_of_the_one_in_the_page(tmp_path, monkeypatch, capsys):
    page = tmp_path / "page.md"
    page.write_text("# A page\n\n## A\nwords\n\n| x |\n| --- |\n| 1 |\n\n## B\n\n| x |\n")
    monkeypatch.setattr("sys.argv", ["prog", "--page", str(page)])
    into_page("prog", "## A", ("law", "V"), iter([("pi", "0"), ("lqi", "2")]), "Words.")
    made = "| law | V |\n| --- | --- |\n| pi | 0 |\n| lqi | 2 |\n"
    assert page.read_text() == f"# A page\n\n## A\nwords\n\n{made}\n## B\n\n| x |\n"
    assert capsys.readouterr().out == "pi 0\nlqi 2\n"
    never = iter(lambda: pytest.fail("a row was made for a page without a place for it"), None)
    with pytest.raises(SystemExit, match=r"page.md: no table under '## C'"):
        into_page("prog", "## C", ("law", "V"), never, "Words.")


def test_the_plant_is_compared_under_each_law_and_with_each_effect(monkeypatch):
    """The rows are made, none is played."""
    monkeypatch.setattr(plant_page, "plant_row", lambda label, wrists, steps: [label, len(wrists), steps])
    monkeypatch.setattr(plant_page, "showing", lambda form, wrist, steps: wrist)
    rows = list(plant_page.plant_rows(WRIST, 77))
    assert rows[:2] == [["declared", 1, 77], ["declared, of plays", 1, 77]]
    assert rows[2:] == [[name, len(forms), 77] for name, forms in EFFECTS.items()]


def test_the_second_law_is_about_as_wide_and_as_steep_as_the_first_and_curved():
    one, other = WRIST.hysteresis, of_plays(WRIST).hysteresis
    assert other.steepness == pytest.approx(one.steepness, rel=0.05)
    assert float(other.flattest) == pytest.approx(float(one.flattest), rel=0.05)
    gaps = [float(p.descending(100.0) - p.ascending(100.0)) for p in (one, other)]
    assert gaps[1] == pytest.approx(gaps[0], rel=0.15)
    assert not other.straight()
    slopes = other.branches(*WRIST.rig.pressure_range).values()
    assert len(set(slopes)) == 3
    assert max(slopes) == pytest.approx(float(one.a1), rel=0.15)
