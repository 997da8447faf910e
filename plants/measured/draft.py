"""A campaign.toml to start from, for a folder that holds logs and none."""

import re
from pathlib import Path

import numpy as np
import tomlkit

from plants.errors import InputError
from plants.measured.formats.cells import Text
from plants.measured.formats.columns import STANDARD
from plants.measured.formats.tables import Table, read_table
from plants.measured.importing.names import HINTS

SUFFIXES = (".csv", ".mat", ".parquet")

VALIDATE = 0.34
"""Share of the logs that is kept for reporting the error."""


def draft(folder: Path) -> str | None:
    """What a campaign.toml of the logs in a folder may look like, None where there are no logs.

    Columns are guessed by their names, the sample time from the first log; the last logs are held out.
    """
    logs = sorted(p for p in folder.iterdir() if p.suffix.lower() in SUFFIXES and p.is_file())
    if not logs:
        return None
    document = tomlkit.document()
    document.add(tomlkit.comment("A draft, guessed from the names of the columns: correct it"))
    document["axis"] = re.sub(r"[^A-Za-z0-9-]+", "-", folder.resolve().name).strip("-").lower() or "motion"
    document["start"] = "unknown"
    kept = max(1, round(VALIDATE * len(logs))) if len(logs) > 1 else 0
    columns, sample_time = _columns(logs[0])
    document["sample_time_s"] = sample_time
    document["fit"] = [p.name for p in logs[: len(logs) - kept]]
    if kept:
        document["validate"] = [p.name for p in logs[len(logs) - kept :]]
    if columns:
        document["columns"] = columns
    return tomlkit.dumps(document)


def _columns(log: Path) -> tuple[dict[str, str], float]:
    """Guessed sources of the standard columns, and the sample time [s]; 0.01 where no time can be read."""
    try:
        table = read_table(log)
    except InputError:
        return {}, 0.01
    found: dict[str, str] = {}
    for standard in (*HINTS, *STANDARD):
        if standard in table.columns:
            continue
        name = _named(table, standard, found)
        if name is not None:
            found[standard] = name
    time = table.columns.get(found.get("time_s", "time_s"))
    if time is None or isinstance(time, Text) or len(time) < 2:
        return found, 0.01
    step = float(np.median(np.diff(time)))
    return found, float(f"{step:.4g}") if step > 0.0 else 0.01


def _named(table: Table, standard: str, taken: dict[str, str]) -> str | None:
    if standard not in HINTS:
        return None
    names = [n for n in table.columns if n not in taken.values() and n not in STANDARD]
    return next((n for n in names if re.search(HINTS[standard], n.lower())), None)
