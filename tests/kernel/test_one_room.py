"""CasADi and numba are known in one room, but to those who state that they optimise with CasADi."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
OPTIMISE = {"design/limit/optimal.py", "design/mpc/nlp.py", "design/mpc/prediction.py"}
KNOWS = re.compile(r"import casadi|import numba|from numba|\bnjit\b|\bcasadi\.|fastmath")


def test_nobody_else_knows_them_in_strings_or_otherwise():
    files = [f for room in ("plants", "design", "reports") for f in (ROOT / room).rglob("*.py")]
    assert len(files) > 100
    know = {str(f.relative_to(ROOT)) for f in files if KNOWS.search(f.read_text())}
    outside = {f for f in know if not f.startswith("plants/kernel/")}
    assert outside == OPTIMISE
    assert "plants/kernel/templates.py" in know
