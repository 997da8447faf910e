"""Reading ASAM MDF (.mf4, .mdf), as loggers of vehicles and test benches write it, by asammdf."""

from pathlib import Path

import numpy as np

from plants.measured.formats.binary.extras import needed
from plants.measured.formats.channel import LoggedChannel, numeric


def read_mdf(path: Path) -> list[LoggedChannel]:
    """The numeric channels of a measurement, in physical units, each on the time axis of its group.

    Raises InputError where asammdf is missing.
    """
    asammdf = needed("asammdf", "mdf4", path)
    found = []
    with asammdf.MDF(path) as measured:
        for signal in measured.iter_channels(skip_master=True, copy_master=True):
            values = numeric(signal.samples)
            if values is not None:
                time = np.asarray(signal.timestamps, float)
                found.append(LoggedChannel(signal.name, signal.unit or "", time, values))
    return found
