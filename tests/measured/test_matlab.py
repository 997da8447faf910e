"""MATLAB files in the layouts that Simulink and ControlDesk write, old (v7) and new (v7.3)."""

import struct
from pathlib import Path

import hdf5storage
import numpy as np
import pytest
import scipy.io

from plants.errors import InputError
from plants.measured.campaigns.campaign import load_recording
from plants.measured.formats.binary.apart import apart
from plants.measured.formats.tables import read_table

ROWS = 6
TIME = np.arange(ROWS) * 0.01
COMMAND, ANGLE, PRESSURE = 2.0 + TIME, 100.0 * TIME, 100.0 + TIME


def tall(values: np.ndarray) -> np.ndarray:
    return values[:, None]


def structures(*elements: dict[str, object]) -> np.ndarray:
    """A MATLAB structure array."""
    array = np.zeros((1, len(elements)), dtype=[(name, object) for name in elements[0]])
    for i, element in enumerate(elements):
        for name, value in element.items():
            array[0, i][name] = value
    return array


def signal(values: np.ndarray, label: str, block: str = "rig/Scope") -> dict[str, object]:
    return {"values": values, "dimensions": 1.0, "label": label, "blockName": block}


@pytest.fixture(params=["v7", "v7 compressed", "v7.3"])
def save(request, tmp_path: Path):
    """Write variables in one of the formats: ``save(variables)`` gives the path."""

    def write(variables: dict[str, object]) -> Path:
        path = tmp_path / "log.mat"
        if request.param == "v7.3":
            hdf5storage.savemat(
                str(path), variables, format="7.3", oned_as="column", store_python_metadata=False
            )
        else:
            scipy.io.savemat(
                path, variables, oned_as="column", do_compression=request.param == "v7 compressed"
            )
        return path

    return write


def check(recording) -> None:
    np.testing.assert_allclose(recording.time, TIME)
    np.testing.assert_allclose(recording.command, COMMAND)
    np.testing.assert_allclose(recording.angle, ANGLE)


def refusal(path: Path, columns=None) -> str:
    with pytest.raises(InputError) as caught:
        load_recording(path, columns)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_plain_vectors(save):
    path = save(
        {
            "time_s": tall(TIME), "command_V": COMMAND[None, :], "angle_deg": tall(ANGLE),
            "flag": tall(TIME > 0.02), "Ts": 0.01, "gains": tall(np.ones(3)), "note": "first try",
        }
    )  # fmt: skip
    r = load_recording(path)
    check(r)
    assert list(r.extra) == ["flag"]
    assert r.name == "log.mat"


def test_structure_with_time_with_several_signals(save):
    signals = structures(
        signal(tall(COMMAND), "command_V"),
        signal(tall(ANGLE), "angle_deg"),
        signal(np.column_stack([PRESSURE, PRESSURE + 50.0]), "p"),
        signal(tall(TIME**2), ""),
    )
    r = load_recording(
        save({"log": {"time": tall(TIME), "signals": signals, "blockName": "rig/Scope"}}),
        {"time_s": "time", "pressure_kPa": "p[0]", "other_pressure_kPa": "p[1]"},
    )
    check(r)
    np.testing.assert_allclose(r.pressure, PRESSURE)
    np.testing.assert_allclose(r.other_pressure, PRESSURE + 50.0)
    np.testing.assert_allclose(r.extra["log.signals[3]"], TIME**2)


def test_a_structure_with_time_for_each_signal(save):
    one = {"time": tall(TIME), "signals": signal(tall(COMMAND), "", "rig/u"), "blockName": "rig/u"}
    two = {"time": tall(TIME), "signals": signal(tall(ANGLE), "", "rig/phi"), "blockName": "rig/phi"}
    path = save({"u": one, "phi": two})
    r = load_recording(path, {"time_s": "u.time", "command_V": "u", "angle_deg": "phi"})
    check(r)
    assert not r.extra  # the other time is the same time


def test_unlabelled_signals_go_by_the_name_of_their_block(save):
    signals = structures(signal(tall(COMMAND), "", "rig/u"), signal(tall(ANGLE), "", "rig/phi"))
    path = save({"log": {"time": tall(TIME), "signals": signals}})
    check(load_recording(path, {"time_s": "time", "command_V": "rig/u", "angle_deg": "rig/phi"}))


@pytest.mark.parametrize("upright", [True, False])
def test_a_matrix_with_the_time_in_its_first_column_or_row(save, upright):
    matrix = np.column_stack([TIME, COMMAND, ANGLE])
    path = save({"data": matrix if upright else matrix.T})
    check(load_recording(path, {"time_s": "data[0]", "command_V": "data[1]", "angle_deg": "data[2]"}))


COMMAND_NAME = '"Model Root"/"u [V]"/"Out1"'
ANGLE_NAME = '"Model Root"/"phi [deg]"/"Out1"'


def capture_signal(name: str, data: np.ndarray, path: str = "") -> dict[str, object]:
    return {"Name": name, "Type": 0.0, "Data": data, "Unit": "", "Path": path, "XIndex": 1.0}


@pytest.mark.parametrize("several", [True, False])
def test_a_controldesk_capture(save, several):
    x = {"Name": "", "Raster": "HostService", "Data": TIME[None, :]}
    y = structures(capture_signal(COMMAND_NAME, COMMAND[None, :]), capture_signal(ANGLE_NAME, ANGLE[None, :]))
    path = save({"capture_001": {"X": structures(x) if several else x, "Y": y, "Description": "run 1"}})
    columns = {"time_s": "HostService", "command_V": COMMAND_NAME, "angle_deg": ANGLE_NAME}
    check(load_recording(path, columns))


def test_captured_signals_of_one_name_go_by_their_paths(save):
    y = structures(capture_signal("Out1", COMMAND, "Model/u"), capture_signal("Out1", ANGLE, "Model/phi"))
    path = save({"capture": {"X": {"Data": TIME}, "Y": y}})
    check(load_recording(path, {"time_s": "X", "command_V": "Model/u/Out1", "angle_deg": "Model/phi/Out1"}))


def test_other_structures_go_by_the_names_of_their_fields(save):
    path = save({"run": {"t": tall(TIME), "in": {"u": tall(COMMAND)}, "Y": tall(ANGLE), "X": tall(TIME)}})
    check(load_recording(path, {"time_s": "run.t", "command_V": "run.in.u", "angle_deg": "run.Y"}))


def test_a_missing_column_lists_the_names_in_the_file(save):
    path = save({"a": tall(TIME), "b": tall(COMMAND)})
    assert refusal(path, {"time_s": "t"}) == (
        f"{path}: no column 't', to which [columns] maps time_s; the file has 'a', 'b'"
    )


def test_columns_that_were_not_logged_together(save):
    path = save({"time_s": tall(TIME), "command_V": tall(COMMAND), "angle_deg": tall(ANGLE[:4])})
    assert refusal(path) == (
        f"{path}: column 'angle_deg' has 4 values but the time 'time_s' has {ROWS}; "
        "choose columns that were logged together"
    )


def test_a_value_that_is_not_finite_is_counted_from_one(save):
    angle = ANGLE.copy()
    angle[3] = np.nan
    path = save({"time_s": tall(TIME), "command_V": tall(COMMAND), "angle_deg": tall(angle)})
    assert refusal(path).startswith(f"{path}: row 4, column 'angle_deg': the cell is NaN; ")


def test_one_value(save):
    path = save({"time_s": 0.0, "command_V": 2.0, "angle_deg": 0.0})
    assert refusal(path) == f"{path}: has only 1 row; a recording needs at least 2"


def test_nothing_numeric(save):
    path = save({"note": "first try"})
    assert refusal(path) == f"{path}: holds no numeric vectors; its variables are 'note'"


def test_a_file_that_is_cut_off(save):
    noise = np.random.default_rng(1).normal(size=500)
    path = save({"log": {"time": tall(noise), "signals": structures(*[signal(tall(noise), "a")] * 3)}})
    whole = path.read_bytes()
    for part in (0.0005, 0.01, 0.1, 0.5, 0.9, 0.99):
        path.write_bytes(whole[: max(1, int(part * len(whole)))])
        said = refusal(path)
        assert said.startswith(f"{path}: cannot be read as a MATLAB file (")
        assert said.endswith("); it may be cut off: export it again")


def test_a_file_that_is_none_of_matlab(tmp_path: Path):
    path = tmp_path / "log.mat"
    path.write_text("time_s,command_V\n" * 50)
    assert refusal(path).startswith(f"{path}: cannot be read as a MATLAB file (")


def timeseries_v7() -> bytes:
    """A MATLAB object as v7 files hold it, which no public writer makes."""

    def element(kind: int, data: bytes) -> bytes:
        return struct.pack("<II", kind, len(data)) + data + b"\0" * (-len(data) % 8)

    def flags(kind: int) -> bytes:
        return element(6, struct.pack("<II", kind, 0))

    inner = flags(13) + element(5, struct.pack("<ii", 6, 1)) + element(1, b"") + element(6, b"\1\0\0\0" * 6)
    names = element(1, b"angle") + element(1, b"MCOS") + element(1, b"timeseries")
    return element(14, flags(17) + names + element(14, inner))


def save_with_object(path: Path, version: str, variables: dict[str, object]) -> None:
    if version == "v7":
        scipy.io.savemat(path, variables)
        path.write_bytes(path.read_bytes() + timeseries_v7())
        return
    import h5py

    hdf5storage.savemat(str(path), {"unused": "text", **variables}, format="7.3", store_python_metadata=False)
    with h5py.File(path, "a") as file:
        file["angle"] = np.ones((6, 1), dtype=np.uint32)
        file["angle"].attrs["MATLAB_class"] = np.bytes_("timeseries")
        file["angle"].attrs["MATLAB_object_decode"] = np.int32(3)
        if not variables:
            del file["unused"]


ADVICE = (
    "MATLAB objects (timeseries, Dataset) cannot be read; in MATLAB, of a timeseries ts: "
    "time = ts.Time; y = ts.Data; save('log.mat', 'time', 'y'); of a Dataset logsout: "
    "for k = 1:logsout.numElements, e = logsout{k}; s.(matlab.lang.makeValidName(e.Name)) = e.Values.Data; "
    "s.time = e.Values.Time; end, save('log.mat', '-struct', 's')"
)


@pytest.mark.parametrize("version", ["v7", "v7.3"])
def test_matlab_objects_are_refused_with_advice(tmp_path: Path, version):
    path = tmp_path / "log.mat"
    save_with_object(path, version, {})
    assert refusal(path) == f"{path}: {ADVICE}"


@pytest.mark.parametrize("version", ["v7", "v7.3"])
def test_what_stands_beside_a_matlab_object_is_read(tmp_path: Path, version):
    path = tmp_path / "log.mat"
    save_with_object(path, version, {"time_s": TIME, "command_V": COMMAND})
    assert list(read_table(path).columns) == ["command_V", "time_s"]
    said = refusal(path)
    assert said.startswith(f"{path}: no column 'angle_deg'; the file has 'command_V', 'time_s'; ")
    assert said.endswith(ADVICE)


@pytest.mark.slow
@pytest.mark.parametrize("version", ["v7", "v7 compressed", "v7.3"])
def test_flipped_bits_are_refused_or_read_and_never_end_the_process(tmp_path: Path, version):
    path = tmp_path / "log.mat"
    variables = {"time": TIME, "log": {"theta": ANGLE, "p": PRESSURE}, "u": COMMAND}
    if version == "v7.3":
        hdf5storage.savemat(str(path), variables, format="7.3", store_python_metadata=False)
    else:
        scipy.io.savemat(path, variables, do_compression=version == "v7 compressed")
    whole, draw = path.read_bytes(), np.random.default_rng(7)
    refused = []
    for _ in range(40):
        spoiled = bytearray(whole)
        spoiled[int(draw.integers(len(whole)))] ^= 1 << int(draw.integers(8))
        path.write_bytes(spoiled)
        try:
            read_table(path)
        except InputError as error:
            refused.append(str(error))
    assert refused
    assert not any("\n" in line for line in refused)
    path.write_bytes(whole)
    assert "log.theta" in read_table(path).columns


def test_a_reader_that_breaks_down_is_told_and_replaced(tmp_path: Path):
    with pytest.raises(InputError, match="its reader broke down over it; the file is damaged"):
        apart("os", "_exit", 3)
    path = tmp_path / "log.mat"
    scipy.io.savemat(path, {"time": TIME})
    assert "time" in read_table(path).columns


def test_a_file_is_found_from_the_folder_in_which_one_is_now(tmp_path, monkeypatch):
    """The worker that reads was started in another."""
    scipy.io.savemat(tmp_path / "log.mat", {"time": np.arange(3.0), "u": np.ones(3)})
    read_table(tmp_path / "log.mat")
    monkeypatch.chdir(tmp_path)
    assert set(read_table("log.mat").columns) == {"time", "u"}
