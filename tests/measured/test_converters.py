"""Columns in units of the recorder: pressures, converter counts, orientations."""

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from plants.errors import InputError
from plants.measured.campaign import load_recording
from plants.measured.formats.columns import parse_columns


@pytest.mark.parametrize(
    ("entry", "raw", "expected"),
    [
        ({"name": "p", "unit": "bar"}, 1.5, 150.0),
        ({"name": "p", "unit": "mbar", "absolute": True}, 2013.25, 100.0),
        ({"name": "p", "unit": "psi"}, 14.503773773, 100.0),
        ({"name": "p", "counts": 4095, "full": 200.0}, 2047.5, 100.0),
    ],
)
def test_a_pressure_comes_in_kPa(entry, raw, expected):
    source = parse_columns({"pressure_kPa": entry}, "campaign.toml")["pressure_kPa"]
    assert source.scale * raw + source.offset == pytest.approx(expected)


def test_an_orientation_becomes_the_angle_that_it_turned(tmp_path):
    """Against scipy: a tilted sensor that turns about an axis of its own."""
    angle = 30.0 * np.sin(np.arange(200) / 20)
    mounted = Rotation.from_euler("xyz", [20, 40, 60], degrees=True)
    seen = (mounted * Rotation.from_rotvec(np.outer(np.radians(angle), [0.0, 0.6, 0.8]))).as_quat()
    frame = pd.DataFrame({"time_s": np.arange(200) * 0.01, "command_V": 1.0 + angle / 30.0})
    for i, name in enumerate(("qx", "qy", "qz", "qw")):
        frame[name] = seen[:, i]
    frame.to_csv(tmp_path / "log.csv", index=False)
    columns = {"angle_deg": {"quaternion": ["qw", "qx", "qy", "qz"]}}
    found = load_recording(tmp_path / "log.csv", columns)
    assert found.angle is not None
    np.testing.assert_allclose(np.abs(found.angle), np.abs(angle), atol=1e-6)


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ({"name": "p", "unit": "furlong"}, "unit 'furlong' is unknown"),
        ({"name": "p", "unit": "bar", "scale": 2.0}, "do not go with unit"),
        ({"name": "p", "counts": 0, "full": 1.0}, "counts 0 must be a positive number"),
        ({"quaternion": ["w", "x"]}, "four columns"),
    ],
)
def test_an_entry_that_makes_no_sense_is_refused(entry, said):
    with pytest.raises(InputError, match=said):
        parse_columns({"pressure_kPa": entry}, "campaign.toml")
