"""Tables and figures that only notebooks show say what the computation behind them says."""

import numpy as np
import pytest

from design import PI
from design.robustness.certificates.sampled.growth import growth_of
from design.robustness.certificates.sampled.sampled_loop import vertices, word_of
from design.robustness.loop_model import LoopModel
from design.synthesis.evaluate import evaluate
from design.synthesis.requirements import default_problem
from design.synthesis.tuning_rules import baselines
from plants import Wrist
from plants.wrist import SAMPLE_TIME
from reports.notebooks.figures import word_growth
from reports.notebooks.tables import BROKEN, rows, shown
from reports.notebooks.tables import limits_held as limits_table
from reports.shared.tables import Cell, Column, Group, Table, row


def test_a_cross_stands_behind_what_breaks_a_limit_and_nothing_else():
    wrist = Wrist.flexion()
    rule = baselines(wrist)["SIMC"]
    problem = default_problem(wrist)
    at = evaluate(problem, (1.2, rule.Kp), (2.2, rule.Ki))
    text = limits_table(problem, at, ("safe", "SIMC")).text
    head, _, safe, simc = ([c.strip() for c in line.split("|")[1:-1]] for line in text.splitlines())
    broken = {h for h, c in zip(head, simc, strict=True) if BROKEN in c}
    assert broken == {"Overshoot [%]", "Ms [1]", "Mt [1]"}
    assert not [c for c in safe if BROKEN in c]


def test_a_table_keeps_its_shape_whatever_its_cells_say():
    cells = row("a|b\nc", Cell("5", "range", broken=True), Cell("*", marked=True))
    table = Table((Column("x", number=False), Column("y", "V"), Column("z")), (Group("group", (cells,)),))
    lines = shown(table).text.splitlines()
    assert [line.replace("\\|", "").count("|") for line in lines] == [4] * 4
    assert lines[2].startswith("| **group** |")
    assert lines[3] == f"| a\\|b c | **5 (range){BROKEN}** | *\\** |"
    assert shown(table)._repr_markdown_() == repr(shown(table))


def test_records_without_a_row_are_refused_and_never_is_a_sign():
    with pytest.raises(ValueError, match="no rows"):
        rows([])
    assert rows([{"settling": float("inf")}]).text.endswith("| ∞ |")


def test_the_drawn_word_grows_from_pass_to_pass_as_its_spectral_radius_says():
    model = LoopModel.of(Wrist.flexion(), PI(1.0, 40.0))
    word = word_of(model)
    assert word is not None
    *alone, under = word_growth(growth_of(model, word, passes=4)).axes[0].lines[: len(set(word.names)) + 1]
    once = round(sum(round(d / SAMPLE_TIME) for d in word.dwells))
    size = np.asarray(under.get_ydata())
    assert np.allclose(size[once::once] / size[:-1:once], word.radius, rtol=1e-3)
    for line in alone:  # and each letter alone is stable
        name = line.get_label().removeprefix("only ")
        assert np.abs(np.linalg.eigvals(vertices(model)[name])).max() < 1.0
