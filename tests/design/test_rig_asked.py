"""Code that serves any rig asks it, and not the built-in one: only the files listed here do, for a reason.

Defaults of parameters and fields may be the built-in rig's, as its own parameter set is a default: who has
a rig gives its numbers.  Numbers themselves: `test_rig_numbers`.
"""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

TAKEN = {
    "built_in_rig", "built_in", "STEP", "SAMPLE_TIME", "COMMAND_RANGE", "SETTLING_BAND", "flexion",
}  # fmt: skip
"""Names by which the built-in rig's numbers and motions are to be had."""

BUILT_IN = {
    "design/cli/common.py": "the option --axis",
    "design/cli/completion.py": "the option --axis",
    "design/cli/commands/compare.py": "what --example compares",
    "design/cli/app.py": "units of words before a plant is known",
    "design/controllers/lqi.py": "the plant of defaults",
    "design/controllers/pi.py": "the plant of defaults",
    "design/evaluation/metrics.py": "judges made without a rig",
    "design/evaluation/scenarios.py": "the names STEP and Spread's defaults",
    "design/export/catalogue.py": "units in which names in C are written",
    "design/export/cortex/__main__.py": "the plant whose controllers are counted",
    "design/export/misra.py": "the plant whose controllers are checked",
    "design/export/plant/__main__.py": "the plant whose effects the table compares",
    "design/export/table.py": "the plant whose controllers the table compares",
    "design/export/vectors.py": "how long a test vector is",
    "design/mpc/prediction.py": "a wrist whose graph is taken, its numbers not",
    "design/robustness/certificates/constant/mu_sweep.py": "another STEP, of a grid",
    "design/robustness/samples/conditions.py": "defaults of conditions",
    "design/studies/design_study.py": "its motions, which are declared and not guessed",
    "design/studies/paper.py": "the paper's figures",
    "design/synthesis/requirements.py": "defaults of limits",
    "design/synthesis/tuning.py": "whose gains the region of `Region` is",
    "design/tuner/widget.py": "its own motions by name",
    "plants/effects/effect.py": "units in which effects are written",
    "plants/measured/campaigns/campaign.py": "whose motion an axis is, standard units",
    "plants/measured/guess/rig.py": "a rig for a log that names none",
    "plants/measured/trace/ranking/screening.py": "units in which effects are written",
    "plants/measured/trace/start.py": "whose motion an axis is",
    "plants/parameters/files.py": "the rig of a file that names none",
    "plants/rig.py": "the built-in rig itself",
    "plants/wrist.py": "the built-in wrist itself",
    "reports/paper/figures.py": "the paper's figures",
    "reports/paper/plots.py": "the paper's figures",
    "reports/shared/names.py": "titles of its motions",
    "reports/shared/units.py": "units in which words are written",
}
"""Files that take them other than as a default, and for what."""


def defaults(tree: ast.AST) -> set[ast.AST]:
    """Every node of a default of a parameter or of a field."""
    given: list[ast.AST] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.arguments):
            given += [d for d in (*node.defaults, *node.kw_defaults) if d is not None]
        elif isinstance(node, ast.ClassDef):
            given += [s.value for s in node.body if isinstance(s, ast.AnnAssign) and s.value is not None]
    return {inner for d in given for inner in ast.walk(d)}


def taken(text: str) -> Iterator[str]:
    """What a module takes of the built-in rig."""
    tree = ast.parse(text)
    left_out = defaults(tree)
    for node in ast.walk(tree):
        if node in left_out:
            continue
        if isinstance(node, ast.Name | ast.Attribute):
            name = node.id if isinstance(node, ast.Name) else node.attr
            if name in TAKEN:
                yield name
        elif isinstance(node, ast.Constant) and node.value in ("flexion", "deviation"):
            yield str(node.value)


def test_what_is_taken_is_seen():
    assert list(taken("from plants import STEP\nx = STEP\n")) == ["STEP"]
    assert list(taken("def f(dt=SAMPLE_TIME): ...\n")) == []
    assert list(taken("class A:\n    low: float = COMMAND_RANGE[0]\n")) == []
    assert list(taken("if axis == 'flexion': ...\n")) == ["flexion"]


@pytest.mark.slow
def test_only_the_files_listed_take_numbers_of_the_built_in_rig():
    found = {}
    for room in ("plants", "design", "reports"):
        for path in sorted((ROOT / room).rglob("*.py")):
            names = sorted(set(taken(path.read_text())))
            if names:
                found[str(path.relative_to(ROOT))] = names
    assert {p: names for p, names in found.items() if p not in BUILT_IN} == {}
    assert sorted(set(BUILT_IN) - set(found)) == []  # the list is no longer than it has to be
