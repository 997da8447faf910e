"""Reading MATLAB files, as Simulink and dSPACE ControlDesk write them.

Names that columns get:

    numeric vector x                 x
    matrix m, signals along its      m[0], m[1], ... (Simulink's "Array" format: m[0] is the time)
    shorter side
    structure s with field f         s.f
    Structure With Time s            time, and each signal by its label; an unlabelled one by the
                                     block's name, or the structure's where it is the only one
    ControlDesk capture              X (or its Name or Raster) and each signal of Y by its full Name

Where two structures of a file give the same name, both get the longer s.name.
"""

import warnings
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from plants.errors import InputError
from plants.measured.formats.binary.apart import apart
from plants.measured.formats.cells import Array, Column, one_line, shorten

READABLE = {
    "cell", "char", "double", "function", "int8", "int16", "int32", "int64", "logical", "single", "sparse",
    "struct", "uint8", "uint16", "uint32", "uint64", "unknown",
}  # fmt: skip
ADVICE = (
    "MATLAB objects (timeseries, Dataset) cannot be read; in MATLAB, of a timeseries ts: "
    "time = ts.Time; y = ts.Data; save('log.mat', 'time', 'y'); of a Dataset logsout: "
    "for k = 1:logsout.numElements, e = logsout{k}; s.(matlab.lang.makeValidName(e.Name)) = e.Values.Data; "
    "s.time = e.Values.Time; end, save('log.mat', '-struct', 's')"
)


def read_mat(path: Path) -> tuple[dict[str, Column], str]:
    """Numeric vectors of a .mat file (v4 to v7.3) by name, and a note on what could not be read.

    Vectors may differ in length: a file also holds constants.
    Raises InputError for a damaged file and for one that holds nothing but MATLAB objects.
    """
    variables, objects = apart(__name__, "load_mat", path)
    found = [item for name, value in variables.items() for item in _walk(name, value)]
    columns = {name: values for name, values in _named(found) if values.size}
    if objects and not columns:
        raise InputError(f"{path}: {ADVICE}")
    if not columns:
        raise InputError(f"{path}: holds no numeric vectors; its variables are {shorten(list(variables))}")
    return dict(columns), ADVICE if objects else ""


def load_mat(path: Path) -> tuple[dict[str, Any], bool]:
    """Variables by name, and whether the file holds objects, at the top or inside a structure.

    Runs apart: a damaged file may end the process that reads it.
    Raises InputError for a damaged file.
    """
    import pymatreader

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            found = pymatreader.read_mat(path)
            objects = _objects(path, found)
        except Exception as error:  # damaged bytes make the readers raise nearly anything
            raise _damaged(path, error) from None
    said = [str(w.message) for w in caught]
    broken = [s for s in said if s.startswith("Unreadable variable")]
    variables = {n: found[n] for n in sorted(found) if n[:1] not in "#_" and n not in objects}
    if broken or not (variables or objects):
        raise _damaged(path, broken[0] if broken else "no variables")
    return variables, bool(objects) or any("Complex objects" in s for s in said)


def _objects(path: Path, found: Mapping[str, Any]) -> set[str]:
    """Names of the variables that are MATLAB objects."""
    import h5py
    import pymatreader

    if h5py.is_hdf5(path):
        return {name for name, _, kind in pymatreader.whosmat(path) if kind not in READABLE}
    # The listing of older files fails on objects; they are known by the fields that scipy gives
    # them, which its version 1.18 renamed.
    return {n for n, v in found.items() if isinstance(v, Mapping) and ("_TypeSystem" in v or "s0" in v)}


def _damaged(path: Path, reason: Any) -> InputError:
    return InputError(
        f"{path}: cannot be read as a MATLAB file ({one_line(reason)}); it may be cut off: export it again"
    )


Item = tuple[str, str, Any]  # short name, full name, vector


def _walk(name: str, value: Any) -> Iterator[Item]:
    """The vectors inside a variable."""
    if isinstance(value, Mapping):
        if "time" in value and isinstance(value.get("signals"), Mapping | list):
            yield from _structure_with_time(name, value)
        elif "X" in value and isinstance(value.get("Y"), Mapping | list):
            yield from _capture(name, value)
        else:
            for field, inner in sorted(value.items()):
                yield from _walk(f"{name}.{field}", inner)
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            yield from _walk(f"{name}[{i}]", inner)
    else:
        yield from ((n, n, v) for n, v in _vectors(name, value))


def _vectors(name: str, value: Any, length: int | None = None) -> Iterator[tuple[str, Array]]:
    """An array as vectors: itself, or its columns; its rows where these are longer, or of `length`."""
    if not isinstance(value, np.ndarray | int | float | np.generic):
        return
    array = np.atleast_1d(value)
    if array.dtype.kind not in "biuf":
        return
    if array.ndim == 1:
        yield name, array.astype(np.float64)
    elif array.ndim == 2:
        upright = array.shape[0] >= array.shape[1] if length is None else array.shape[0] == length
        for i, signal in enumerate(array.T if upright else array):
            yield f"{name}[{i}]", signal.astype(np.float64)


def _structure_with_time(name: str, value: Mapping[str, Any]) -> Iterator[Item]:
    yield from (("time", f"{name}.time", v) for _, v in _vectors("time", value["time"]))
    signals = _elements(value["signals"], "values")
    blocks = Counter(_string(s.get("blockName")) for s in signals)
    for i, signal in enumerate(signals):
        label, block = _string(signal.get("label")), _string(signal.get("blockName"))
        if not label and len(signals) == 1:
            label = full = name
        elif not label and blocks[block] > 1:
            label = full = f"{name}.signals[{i}]"
        else:
            label = label or block or f"signals[{i}]"
            full = f"{name}.{label}"
        length = np.size(value["time"])
        for short, vector in _vectors(label, signal.get("values"), length):
            yield short, full + short[len(label) :], vector


def _capture(name: str, value: Mapping[str, Any]) -> Iterator[Item]:
    for axis in ("X", "Y"):
        signals = _elements(value[axis], "Data")
        for i, signal in enumerate(signals):
            label = _string(signal.get("Name")) or (_string(signal.get("Raster")) if axis == "X" else "")
            label = label or (axis if len(signals) == 1 else f"{axis}[{i}]")
            path = _string(signal.get("Path"))
            full = f"{path}/{label}" if path else f"{name}.{axis}[{i}].{label}"
            for short, vector in _vectors(label, signal.get("Data")):
                yield short, full + short[len(label) :], vector


def _elements(value: Any, main: str) -> list[Mapping[str, Any]]:
    """The elements of a structure array, which arrives as one structure with lists in its fields."""
    if isinstance(value, list):
        return [v for v in value if isinstance(v, Mapping)]
    if not isinstance(value, Mapping):
        return []
    if not isinstance(value.get(main), list):
        return [value]
    count = len(value[main])
    columns = {k: v for k, v in value.items() if isinstance(v, list | np.ndarray) and len(v) == count}
    return [{k: v[i] for k, v in columns.items()} for i in range(count)]


def _string(value: Any) -> str:
    return value.strip() if isinstance(value, str) else ""


def _named(found: list[Item]) -> Iterator[tuple[str, Array]]:
    """Short names where they are unique, full ones where not, numbered where even those repeat."""
    shorts = Counter(short for short, _, _ in found)
    seen: Counter[str] = Counter()
    for short, full, vector in found:
        name = short if shorts[short] == 1 else full
        seen[name] += 1
        yield (name if seen[name] == 1 else f"{name} ({seen[name]})"), vector
