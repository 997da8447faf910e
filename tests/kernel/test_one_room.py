"""CasADi and numba are known in one room, but to those who state that they optimise with CasADi."""

import re
from configparser import ConfigParser
from pathlib import Path

ROOT = Path(__file__).parents[2]
OPTIMISE = {"design/limit/optimal.py", "design/mpc/nlp.py"}
KNOWS = re.compile(r"import casadi|import numba|from numba|\bnjit\b|\bcasadi\.|fastmath")
FILES = [
    str(f.relative_to(ROOT)) for room in ("plants", "design", "reports") for f in (ROOT / room).rglob("*.py")
]


def test_nobody_else_knows_them_in_strings_or_otherwise():
    assert len(FILES) > 100
    know = {f for f in FILES if KNOWS.search((ROOT / f).read_text())}
    outside = {f for f in know if not f.startswith("plants/kernel/")}
    assert outside == OPTIMISE
    assert "plants/kernel/templates.py" in know


def test_the_contract_of_imports_is_about_all_others_and_no_contract_has_an_exception():
    contracts = ConfigParser()
    contracts.read(ROOT / ".importlinter")
    assert not any(contracts.has_option(section, "ignore_imports") for section in contracts.sections())
    sources = contracts["importlinter:contract:engine"]["source_modules"].split()
    rooms = tuple(f"{m.replace('.', '/')}{end}" for m in sources for end in (".py", "/"))
    left = {f for f in FILES if not f.startswith(rooms) and not f.endswith("__init__.py")}
    assert {f for f in left if not f.startswith("plants/kernel/")} == OPTIMISE
