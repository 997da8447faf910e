"""Reading HDF5 of any layout: every numeric series, each on the time of its group."""

from pathlib import Path
from typing import Any

import numpy as np

from plants.measured.formats.channel import LoggedSeries, numeric

UNITS = ("unit", "units", "Unit", "Units", "UNITS")
STEPS = ("dt", "sample_time", "sampling_interval", "increment", "wf_increment")
"""Attributes that tell a unit, and the distance of two samples [s]."""


def read_hdf5(path: Path) -> list[list[LoggedSeries]]:
    """The series of each group of a file: of datasets with one dimension, of the columns of those with two,
    and of the fields of tables.

    Runs apart (`plants.measured.formats.binary.apart`): a damaged file may end the process that reads it.
    """
    import h5py

    found: dict[str, list[LoggedSeries]] = {}

    def look(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset):
            group, _, own = name.rpartition("/")
            found.setdefault(group, []).extend(_series(own, item))

    with h5py.File(path, "r") as file:
        file.visititems(look)
    return list(found.values())


def _series(name: str, item: Any) -> list[LoggedSeries]:
    unit = next((_text(item.attrs[u]) for u in UNITS if u in item.attrs), "")
    step = next((float(item.attrs[s]) for s in STEPS if s in item.attrs), 0.0)
    if item.dtype.names:
        columns = [(n, item[n]) for n in item.dtype.names] if item.ndim == 1 else []
    elif item.ndim == 2 and item.dtype.kind in "biuf":
        table = item[()] if item.shape[0] >= item.shape[1] else item[()].T
        columns = [(f"{name}[{i}]", column) for i, column in enumerate(table.T)]
    else:
        columns = [(name, item[()])] if item.ndim == 1 else []
    return [LoggedSeries(n, unit, v, step) for n, column in columns if (v := numeric(column)) is not None]


def _text(value: Any) -> str:
    value = value.item() if isinstance(value, np.ndarray) and value.size == 1 else value
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
