"""Logs of other people's rigs load; WRIST_DATA names the folder that holds them."""

import os
import shutil
from pathlib import Path

import numpy as np
import pytest

from plants.measured.campaigns.campaign import load_campaign, load_recording
from plants.measured.fitting.fit import fit_campaign
from plants.measured.formats.tables import read_table
from plants.parameters.files import built_in

DATA = os.environ.get("WRIST_DATA")
pytestmark = pytest.mark.skipif(not DATA, reason="WRIST_DATA is not set: no measured data at hand")

SWEEP = """
axis = "pump"
stage = "regulator"
start = "unknown"
sample_time_s = 0.02
fit = ["sweep_kp_10.csv", "sweep_ki_300.csv"]
validate = ["sweep_kp_20.csv"]
[columns]
time_s = "Time"
command_V = {name = "PWM", scale = 0.015686}   # 255 is full scale, as 4 V is
pressure_kPa = "Pressure"
"""
RESPONSE = """
axis = "pump"
stage = "regulator"
start = "unknown"
sample_time_s = 0.05
fit = ["sweep_response_20260121_165542.csv"]
validate = ["sweep_response_20260121_165923.csv"]
[columns]
time_s = "Timestamp_s"
command_V = {name = "Setpoint_kPa", scale = 0.0202429}
pressure_kPa = "Feedback_kPa"
"""


@pytest.mark.parametrize("declaration", [SWEEP, RESPONSE], ids=["sweeps", "responses"])
@pytest.mark.filterwarnings("ignore:.*command .* V is outside 0 to 4 V:plants.errors.InputWarning")
def test_a_pressure_loop_loads_as_a_regulator_campaign(tmp_path: Path, declaration):
    for file in (Path(str(DATA)) / "pressure-loop").glob("*.csv"):
        shutil.copyfile(file, tmp_path / file.name)
    (tmp_path / "campaign.toml").write_text(declaration, encoding="utf-8")
    c = load_campaign(tmp_path)
    assert c.stage == "regulator"
    for r in c.fit + c.validate:
        assert r.angle is None
        assert r.pressure is not None
        assert len(r.time) == len(r.pressure) > 190
        assert r.extra


def test_a_joint_logged_in_matlab_loads(tmp_path: Path):
    path = Path(str(DATA)) / "pam-joint-force" / "data.mat"
    table = read_table(path)
    assert set(table.columns) == {"F", "x", "dx", "p1", "p2"}
    # It has no time: one that runs at its 1 kHz is put beside it.
    import scipy.io

    time = np.arange(len(table.columns["x"])) * 1e-3
    scipy.io.savemat(tmp_path / "log.mat", {"t": time, **table.columns})
    columns = {
        "time_s": "t",
        "command_V": {"name": "p1", "scale": 0.001},
        "angle_deg": "x",
        "pressure_kPa": "p2",
    }
    r = load_recording(tmp_path / "log.mat", columns, sample_time=1e-3)
    assert len(r.time) == 28_027
    assert list(r.extra) == ["F", "dx"]


STEPS = """
axis = "pump"
stage = "regulator"
start = "unknown"
sample_time_s = 0.02
fit = ["sweep_kp_10.csv", "sweep_kp_15.csv", "sweep_kp_20.csv", "sweep_ki_300.csv"]
validate = ["sweep_kp_25.csv", "sweep_ki_500.csv"]
[columns]
time_s = "Time"
command_V = {name = "Target", scale = 0.0202429}
pressure_kPa = "Pressure"
"""


def test_the_regulator_is_fitted_to_a_pressure_loop(tmp_path: Path):
    for file in (Path(str(DATA)) / "pressure-loop").glob("sweep_k*.csv"):
        shutil.copyfile(file, tmp_path / file.name)
    (tmp_path / "campaign.toml").write_text(STEPS, encoding="utf-8")
    found = fit_campaign(load_campaign(tmp_path), built_in("flexion"), starts=3)
    after, before = found.validate_rmse["pressure_kPa"], found.validate_rmse_before["pressure_kPa"]
    # A pump is no such regulator: most of the error goes, and what stays is above the noise.
    assert after < 0.3 * before
    assert after > found.noise["pressure_kPa"]
    assert found.validate_rmse["angle_deg"] is None
    assert found.fitted.axis == "pump"
