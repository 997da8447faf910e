"""Columns in units of the recorder: pressures, converter counts, orientations."""

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from plants.errors import InputError
from plants.measured.campaigns.campaign import load_recording
from plants.measured.formats.columns import ROLES, parse_columns
from plants.measured.formats.units import factor


@pytest.mark.parametrize(
    ("entry", "raw", "expected"),
    [
        ({"name": "p", "unit": "bar"}, 1.5, 150.0),
        ({"name": "p", "unit": "mbar", "absolute": True}, 2013.25, 100.0),
        ({"name": "p", "unit": "hPa", "absolute": True}, 2013.25, 100.0),
        ({"name": "p", "unit": "psi"}, 14.503773773, 100.0),
        ({"name": "p", "counts": 4095, "full": 200.0}, 2047.5, 100.0),
    ],
)
def test_a_pressure_comes_in_kPa(entry, raw, expected):
    source = parse_columns({"pressure_kPa": entry}, "campaign.toml")["pressure_kPa"]
    assert source.scale * raw + source.offset == pytest.approx(expected)


@pytest.mark.parametrize(
    ("column", "unit", "scale"),
    [("command_V", "mV", 1e-3), ("command_V", "%", 1.0), ("time_s", "ms", 1e-3),
     ("reference_deg", "rad", 180.0 / np.pi),
     ("other_pressure_kPa", "bar", 100.0), ("pressure_kPa", "hPa", 0.1), ("angle_deg", "°", 1.0)],
)  # fmt: skip
def test_the_units_of_a_campaign_are_those_of_an_import(column, unit, scale):
    source = parse_columns({column: {"name": "x", "unit": unit}}, "campaign.toml")[column]
    assert source.scale == pytest.approx(scale) == factor(unit, ROLES.get(column, "pressure"), "log")


def test_an_orientation_becomes_the_angle_that_it_turned(tmp_path):
    """Against scipy: a tilted sensor that turns about an axis of its own."""
    angle = 30.0 * np.sin(np.arange(200) / 20)
    mounted = Rotation.from_euler("xyz", [20, 40, 60], degrees=True)
    seen = (mounted * Rotation.from_rotvec(np.outer(np.radians(angle), [0.0, 0.6, 0.8]))).as_quat()
    found = orientation(tmp_path / "log.csv", seen, 1.0 + angle / 30.0)
    assert found.angle is not None
    assert not found.extra
    np.testing.assert_allclose(np.abs(found.angle), np.abs(angle), atol=1e-6)


def orientation(path, seen, command):
    """The recording of quaternions x, y, z, w in the rows of an array."""
    frame = pd.DataFrame({"time_s": np.arange(len(seen)) * 0.01, "command_V": command})
    for i, name in enumerate(("qx", "qy", "qz", "qw")):
        frame[name] = seen[:, i]
    frame.to_csv(path, index=False)
    return load_recording(path, {"angle_deg": {"quaternion": ["qw", "qx", "qy", "qz"]}})


def test_rows_that_lack_a_part_of_an_orientation_do_not_count(tmp_path):
    """Empty cells, in one column or in all, and four zeros, which a sensor sends that has no orientation."""
    angle = 30.0 * np.sin(np.arange(200) / 20)
    seen = Rotation.from_rotvec(np.outer(np.radians(angle), [0.0, 0.6, 0.8])).as_quat()
    seen[20:28], seen[50, 2], seen[90] = np.nan, np.nan, 0.0
    found = orientation(tmp_path / "log.csv", seen, 1.0 + angle / 30.0)
    lacking = np.flatnonzero(~found.fresh("angle_deg"))
    assert lacking.tolist() == [*range(20, 28), 50, 90]
    there = found.fresh("angle_deg")
    np.testing.assert_allclose(found.angle[there], angle[there], atol=1e-6)
    assert np.isfinite(found.angle).all()


def test_an_orientation_that_is_hardly_ever_there_is_refused(tmp_path):
    seen = np.zeros((200, 4))
    seen[:10, 3] = 1.0
    with pytest.raises(InputError, match=r"'qz' is no orientation in row 12; correct it"):
        orientation(tmp_path / "log.csv", seen, np.arange(200) / 100)


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ({"name": "p", "unit": "furlong"}, "unit 'furlong' is none of pressure; give one such as kPa, Pa"),
        ({"name": "p", "unit": "bar", "scale": 2.0}, "do not go with unit"),
        ({"name": "p", "counts": 0, "full": 1.0}, "counts 0 must be a positive number"),
        ({"name": "p", "unit": 3}, "unit 3 is no text; give one such as kPa"),
        ({"quaternion": ["w", "x"]}, "four columns"),
    ],
)
def test_an_entry_that_makes_no_sense_is_refused(entry, said):
    with pytest.raises(InputError, match=said):
        parse_columns({"pressure_kPa": entry}, "campaign.toml")
