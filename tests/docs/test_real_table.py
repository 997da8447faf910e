"""The guide's table of other people's rigs is the one that the kept numbers make."""

from pathlib import Path

from benchmarks.real_rigs.table import kept_table

ROOT = Path(__file__).parents[2]


def test_the_table_of_rigs_is_that_of_the_kept_numbers():
    guide = (ROOT / "docs" / "how-trace-decides.md").read_text(encoding="utf-8")
    assert kept_table().count("\n") > 6
    assert kept_table() in guide
