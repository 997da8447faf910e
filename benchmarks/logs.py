"""Reading a log: a recording of 14,000 rows, checked and named, beside NumPy's reader of text."""

import tempfile
from pathlib import Path

import numpy as np

from benchmarks.timing import duel
from plants.measured.campaigns.campaign import load_recording

ROWS = 14_000

MEANING = {
    "logs.read_vs_loadtxt": "our time to load a recording of 14,000 rows / numpy.loadtxt's",
    "logs.read_ms": "ms, a recording of 14,000 rows",
}
"""What each figure says."""


def measure(rounds: int) -> dict[str, float | None]:
    """Figures of one file of four columns."""
    k = np.arange(ROWS)
    table = np.column_stack((k / 100.0, 2.0 + k % 7 / 10.0, k % 31, k % 97))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "long.csv"
        header = "time_s,command_V,angle_deg,pressure_kPa"
        np.savetxt(path, table, fmt="%.4f", delimiter=",", header=header, comments="")
        assert len(load_recording(path).time) == ROWS
        taken = duel(
            lambda: load_recording(path), lambda: np.loadtxt(path, delimiter=",", skiprows=1), rounds
        )
    return {"logs.read_vs_loadtxt": taken.ratio, "logs.read_ms": 1e3 * taken.first}
