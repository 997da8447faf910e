"""Recordings and campaigns made on the spot, good ones that each test spoils in one way."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from tests.rig.soft.named import CAMPAIGNS

ROWS = 8
HEADER = ("time_s", "command_V", "angle_deg", "pressure_kPa")
DECLARATION = 'axis = "flexion"\nsample_time_s = 0.01\nfit = ["steps.csv"]\nvalidate = ["sine.csv"]\n'


def good_rows(rows: int = ROWS) -> list[list[str]]:
    """Cells of a recording at 100 Hz; row i of the list stands in row i + 2 of the file."""
    t = np.arange(rows) * 0.01
    columns = (t, 2.0 + t, 10.0 * t, 100.0 + 50.0 * t)
    return [[f"{x:.4f}" for x in row] for row in zip(*columns, strict=True)]


@pytest.fixture
def write_csv(tmp_path: Path) -> Callable[..., Path]:
    """Write rows of cells as CSV: ``write_csv(name, rows, header, separator)``."""

    def write(
        name: str = "steps.csv",
        rows: Sequence[Sequence[str]] | None = None,
        header: Sequence[str] = HEADER,
        separator: str = ",",
    ) -> Path:
        lines = [header, *(good_rows() if rows is None else rows)]
        path = tmp_path / name
        path.write_text("".join(separator.join(line) + "\n" for line in lines), encoding="utf-8")
        return path

    return write


@pytest.fixture
def campaign(tmp_path: Path, write_csv: Callable[..., Path]) -> Callable[..., Path]:
    """A folder with two good recordings and a campaign.toml: ``campaign(declaration)``."""

    def make(declaration: str = DECLARATION) -> Path:
        write_csv("steps.csv")
        write_csv("sine.csv")
        (tmp_path / "campaign.toml").write_text(declaration, encoding="utf-8")
        return tmp_path

    return make


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A campaign of the bending actuator of `tests.rig.soft.named`."""
    make, fit, validate = CAMPAIGNS["bender"]
    folder = tmp_path_factory.mktemp("soft") / "bender"
    make().write(folder, fit, validate)
    return folder
