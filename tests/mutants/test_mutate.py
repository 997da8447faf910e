"""Mutants are programs that differ by one fault, the same for the same seed."""

import ast

from tests.mutants.__main__ import ROOMS, ROOT, asked_of, sources
from tests.mutants.mutate import drawn, mutants

TEXT = '''"""A law."""


def law(a: int, b: float = 0.0) -> float:
    """With 2 in its words."""
    if a < 1 and b > 2.0:
        raise ValueError(f"{a + 1} is too small")
    return a * b - max(a, 1)
'''


def test_each_is_a_program_with_one_line_changed(tmp_path):
    path = tmp_path / "law.py"
    path.write_text(TEXT)
    found = mutants(path)
    changed = {m.line for m in found}
    assert changed == {4, 6, 8}  # neither words nor messages nor annotations
    for m in found:
        assert ast.dump(ast.parse(m.text)) != ast.dump(ast.parse(TEXT))
        assert sum(a != b for a, b in zip(m.text.splitlines(), TEXT.splitlines(), strict=True)) == 1
    after = {m.after for m in found}
    assert "return (a / b) - max(a, 1)" in after
    assert "return a * b - (min(a, 1))" in after


def test_a_seed_draws_the_same():
    files = sources("export")
    assert drawn(files, 5, 3) == drawn(files, 5, 3) != drawn(files, 5, 4)


def test_every_source_has_tests_to_be_run():
    for room in ROOMS:
        for path in sources(room):
            assert any((ROOT / t).name.startswith("test_") for t in asked_of(path, room)), path
