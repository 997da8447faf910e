"""``[columns]`` of a campaign.toml, each line with its reason in a comment."""

from collections.abc import Mapping

import tomlkit
from tomlkit.items import Item, Table

from plants.measured.importing.roles import ROLES, Role


def columns_table(found: Mapping[str, Role], columns: Mapping[str, str] | None = None) -> Table:
    """The table of some roles; columns: those of the file by channel, where they differ.

    >>> print(columns_table({"pressure": Role("p", "bar", 100.0, "unit bar")}).as_string().strip())
    pressure_kPa = {name = "p", scale = 100.0} # unit bar
    """
    table = tomlkit.table()
    for role, of in found.items():
        table[ROLES[role]] = in_a_line(of.entry(columns), of.why)
    return table


def in_a_line(entry: str | Mapping[str, object], why: str) -> Item:
    """An entry in one line with a comment, if there is anything to say."""
    value: object = entry
    if not isinstance(entry, str):
        inline = tomlkit.inline_table()
        inline.update(entry)
        value = inline
    item = tomlkit.item(value)
    return item.comment(why) if why else item
