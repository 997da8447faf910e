"""Reading TDMS, as LabVIEW writes it, by npTDMS."""

from pathlib import Path
from typing import Any

import numpy as np

from plants.measured.formats.binary.extras import needed
from plants.measured.formats.channel import LoggedSeries, numeric

UNITS = ("unit_string", "NI_UnitDescription", "Unit", "unit")
"""Properties that tell a unit, in the order of preference."""


def read_tdms(path: Path) -> list[list[LoggedSeries]]:
    """The numeric channels of each group; a channel of time stamps counts seconds from its first.

    Raises InputError where npTDMS is missing.
    """
    nptdms = needed("nptdms", "tdms", path)
    with path.open("rb") as raw, nptdms.TdmsFile.open(raw) as file:  # npTDMS leaves what it refuses open
        return [[s for c in group.channels() if (s := _series(c)) is not None] for group in file.groups()]


def _series(channel: Any) -> LoggedSeries | None:
    cells = channel[:]
    unit = next((str(channel.properties[u]) for u in UNITS if u in channel.properties), "")
    if np.issubdtype(cells.dtype, np.datetime64) and len(cells):
        cells, unit = (cells - cells[0]) / np.timedelta64(1, "s"), "s"
    values = numeric(cells)
    step = float(channel.properties.get("wf_increment", 0.0))
    return None if values is None else LoggedSeries(channel.name, unit, values, step)
