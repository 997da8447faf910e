"""A log written by its format's own library becomes a campaign that holds the same in V, kPa and deg."""

import csv
import json
import tomllib
from pathlib import Path

import numpy as np
import pytest

from plants.measured.campaigns.campaign import load_campaign, load_recording
from plants.measured.importing.importing import import_logs, write_campaign

EXAMPLE = Path(__file__).parents[2] / "plants/measured/examples/flexion"
TRUTH = load_recording(EXAMPLE / "steps.csv").until(30.0)
STEP = 0.01

NAMES = {"dac": ("mV", 1e3 * TRUTH.command), "theta": ("rad", np.deg2rad(TRUTH.angle)),
         "p1": ("bar", TRUTH.pressure / 100.0), "temperature": ("degC", 20.0 + 0.0 * TRUTH.time)}  # fmt: skip
"""What the recorder calls the channels, in its units."""


def mdf4(folder):
    asammdf = pytest.importorskip("asammdf")
    with asammdf.MDF(version="4.10") as file:
        for name, (unit, values) in NAMES.items():
            file.append(asammdf.Signal(values, TRUTH.time, name=name, unit=unit), common_timebase=False)
        return file.save(folder / "log.mf4")


def tdms(folder):
    nptdms = pytest.importorskip("nptdms")
    with nptdms.TdmsWriter(folder / "log.tdms") as file:
        for name, (unit, values) in NAMES.items():
            told = {"unit_string": unit, "wf_increment": STEP, "wf_start_offset": 0.0}
            file.write_segment([nptdms.ChannelObject("rig", name, values, properties=told)])
    return folder / "log.tdms"


def hdf5(folder):
    import h5py

    with h5py.File(folder / "log.h5", "w") as file:
        group = file.create_group("run")
        group["time"] = TRUTH.time
        group["time"].attrs["unit"] = "s"
        for name, (unit, values) in NAMES.items():
            group[name] = values
            group[name].attrs["unit"] = unit
    return folder / "log.h5"


def mcap(folder):
    writer = pytest.importorskip("mcap.writer")
    with (folder / "log.mcap").open("wb") as stream:
        file = writer.Writer(stream)
        file.start()
        schema = file.register_schema("rig", "jsonschema", b'{"type": "object"}')
        channel = file.register_channel("/rig", "json", schema)
        for i, t in enumerate(TRUTH.time):
            row = {f"{n}_{u}": float(v[i]) for n, (u, v) in NAMES.items()}
            stamp = round(1e9 * t) + 10**15
            file.add_message(channel, stamp, json.dumps(row).encode(), stamp)
        file.finish()
    return folder / "log.mcap"


def ros2(folder):
    pytest.importorskip("rosbags")
    from rosbags.rosbag2 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    of = store.types
    with Writer(folder / "bag", version=8) as file:
        joint = file.add_connection("/joint_states", "sensor_msgs/msg/JointState", typestore=store)
        air = file.add_connection("/supply", "sensor_msgs/msg/FluidPressure", typestore=store)
        asked = file.add_connection("/command", "std_msgs/msg/Float64", typestore=store)
        for i, t in enumerate(TRUTH.time):
            stamp = round(1e9 * t) + 10**15
            head = of["std_msgs/msg/Header"](
                of["builtin_interfaces/msg/Time"](stamp // 10**9, stamp % 10**9), "wrist"
            )
            none = np.zeros(0)
            bent = of["sensor_msgs/msg/JointState"](
                head, ["wrist"], np.deg2rad(TRUTH.angle[i : i + 1]), none, none
            )
            pressed = of["sensor_msgs/msg/FluidPressure"](head, 1e3 * float(TRUTH.pressure[i]), 0.0)
            told = of["std_msgs/msg/Float64"](float(TRUTH.command[i]))
            for connection, message in ((joint, bent), (air, pressed), (asked, told)):
                file.write(connection, stamp, store.serialize_cdr(message, connection.msgtype))
    return folder / "bag"


def parquet(folder):
    import pandas as pd

    rows = {"time": TRUTH.time} | {f"{n}_{u}": v for n, (u, v) in NAMES.items() if u != "degC"}
    pd.DataFrame(rows).to_parquet(folder / "log.parquet")
    return folder / "log.parquet"


def matlab(folder):
    import scipy.io

    rows = {"time": TRUTH.time} | {f"{n}_{u}": v for n, (u, v) in NAMES.items() if u != "degC"}
    scipy.io.savemat(folder / "log.mat", rows)
    return folder / "log.mat"


def german(folder):
    """Semicolons, decimal commas, a header of text, a row of units, Windows-1252, a last line of text."""
    lines = [
        "Messgerät;DAQ 7",
        "Prüfer;",
        "",
        "Zeit;dac;theta;p1;temperature;Zustand",
        "[s];[mV];[rad];[bar];[°C];[-]",
    ]
    columns = [TRUTH.time, *(v for _, v in NAMES.values())]
    lines += [
        ";".join([*(repr(float(x)).replace(".", ",") for x in row), "läuft"])
        for row in zip(*columns, strict=True)
    ]
    (folder / "log.csv").write_bytes("\r\n".join([*lines, "Ende der Messung"]).encode("cp1252"))
    return folder / "log.csv"


def excel(folder):
    """As Excel exports "Unicode text": UTF-16, tabs, units in the names, time of day with fractions."""
    head = ["clock", *(f"{n} ({u})" for n, (u, _) in NAMES.items())]
    lines = ["\t".join(head)]
    for i, t in enumerate(TRUTH.time):
        clock = f"09:{int(t // 60) + 5:02d}:{t % 60:09.6f}"
        lines.append("\t".join([clock, *(repr(float(v[i])) for _, v in NAMES.values())]))
    (folder / "log.txt").write_bytes("\r\n".join(lines).encode("utf-16"))
    return folder / "log.txt"


def milliseconds(folder):
    """Commas, quoted names, a time in ms that does not say so, empty cells at the end of each row."""
    with (folder / "log.csv").open("w", newline="") as file:
        out = csv.writer(file)
        out.writerow(["# t", *(f"{n} [{u}]" for n, (u, _) in NAMES.items()), ""])
        for row in zip(1e3 * TRUTH.time, *(v for _, v in NAMES.values()), strict=True):
            out.writerow([*(repr(float(x)) for x in row), ""])
    return folder / "log.csv"


FORMATS = [mdf4, tdms, hdf5, mcap, ros2, parquet, matlab, german, excel, milliseconds]


@pytest.mark.filterwarnings("default")  # of the formats' own libraries
@pytest.mark.parametrize("write", FORMATS, ids=[f.__name__ for f in FORMATS])
def test_a_log_becomes_a_campaign_in_standard_units(write, tmp_path):
    log = write(tmp_path)
    out = tmp_path / "campaign"
    write_campaign(import_logs([Path(log)], {}), "flexion", out)
    (name,) = tomllib.loads((out / "campaign.toml").read_text())["fit"]
    columns = tomllib.loads((out / "campaign.toml").read_text())["columns"]
    found = load_recording(out / name, columns)
    np.testing.assert_allclose(found.time, TRUTH.time - TRUTH.time[0], atol=2e-6)
    np.testing.assert_allclose(found.command, TRUTH.command, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(found.angle, TRUTH.angle, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(found.pressure, TRUTH.pressure, rtol=1e-9, atol=1e-9)
    with pytest.warns(match="only one recording"):
        assert load_campaign(out).axis == "flexion"
