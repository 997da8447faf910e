"""Empty cells of a log stay empty in its campaign, wherever in a row they stand."""

from pathlib import Path

import numpy as np
import pytest

from plants.errors import InputError
from plants.measured.campaigns.campaign import load_recording
from plants.measured.importing.importing import import_logs, table

EXAMPLE = Path(__file__).parents[2] / "plants/measured/examples/flexion"
STEPS = load_recording(EXAMPLE / "steps.csv").until(30.0)
HEAD = "t_s,u_V,p1_kPa,p2_kPa,p3_kPa,theta_deg"


@pytest.fixture
def log(tmp_path):
    """A log with empty cells of some columns in some rows, and a time that jitters."""

    def make(rows, empty, head=HEAD, end=""):
        time = np.round(STEPS.time + 1e-3 * np.random.default_rng(0).random(len(STEPS.time)), 5)
        p = STEPS.pressure
        columns = time, STEPS.command, p, p, p, STEPS.angle
        cells = [[repr(float(x)) for x in row] for row in zip(*columns, strict=True)]
        for i in rows:
            cells[i] = ["" if c in empty else x for c, x in enumerate(cells[i])]
        path = tmp_path / "log.csv"
        path.write_text("\n".join([head, *(",".join(row) + end for row in cells)]) + "\n")
        return path

    return make


@pytest.mark.parametrize("end", ["", ","])
@pytest.mark.parametrize("columns", [(5,), (2, 3, 4, 5)])
def test_rows_with_empty_cells_are_rows(log, columns, end):
    rows = [1700, *range(800, 808)]
    (run,) = import_logs([log(rows, columns, end=end)], {}).runs
    assert len(run.time) == len(STEPS.time)
    lacking = np.flatnonzero(np.isnan(run.values["theta_deg"]))
    assert lacking.tolist() == sorted(rows)
    there = ~np.isnan(run.values["theta_deg"])
    np.testing.assert_array_equal(run.values["theta_deg"][there], STEPS.angle[there])
    np.testing.assert_array_equal(run.values["u_V"], STEPS.command)
    assert table(run).splitlines()[801].endswith(",")


def test_a_channel_that_is_lost_for_long_ends_the_run(log):
    made = import_logs([log(range(1000, 1200), (5,))], {})
    assert "theta_deg was not logged for 2.01 s" in made.runs[0].ends


def test_a_channel_that_fills_every_fourth_row_is_not_filled_in(log):
    rows = [i for i in range(len(STEPS.time)) if i % 4]
    made = import_logs([log(rows, (2,))], {"pressure": ("p1_kPa", "")})
    (run,) = made.runs
    assert np.isfinite(run.values["p1_kPa"]).mean() == pytest.approx(0.25, abs=0.01)


def test_a_log_without_a_time_says_so(log):
    with pytest.raises(InputError, match=r"no time for 'a', .*; give --sample-time in seconds"):
        import_logs([log([], (), head="a,u_V,p1_kPa,p2_kPa,p3_kPa,theta_deg")], {})
