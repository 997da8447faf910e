"""The help of every command groups its options, shows no type for a switch, and names the next command."""

import pytest

from design.cli.app import MODULES
from design.cli.panels import OPTIONS

NAMES = [m.NAME for m in MODULES]


@pytest.mark.parametrize("name", NAMES)
def test_options_stand_in_groups_and_the_next_command_is_named(name, wrist, monkeypatch):
    monkeypatch.setenv("COLUMNS", "100")
    said = wrist(name, "--help").out
    assert "bool" not in said
    assert "Output" in said
    assert "─ Options ─" not in said  # every option belongs to a group
    assert said.rstrip().splitlines()[-1].strip().startswith("Next: ")


def test_an_option_belongs_to_one_group():
    names = [n for group in OPTIONS.values() for n in group]
    assert len(names) == len(set(names))
