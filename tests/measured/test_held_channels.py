"""A channel that the logger renews less often than it writes rows biases nothing: a simulation is compared
with it as the logger writes it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from plants.measured.campaigns.campaign import load_campaign
from plants.measured.instrument.logger import corrected
from plants.measured.trace.rig_fit import fit_rig
from plants.parameters.files import built_in
from tests.rig.campaign import make_rig, record

EXAMPLE = Path(__file__).parents[2] / "plants/measured/examples/flexion"

RENEWED = 17
"""Rows for which a value of the pressure is held: 0.17 s, against 0.1 s that the regulator takes."""


def held(table: pd.DataFrame) -> pd.DataFrame:
    """The log with its pressure renewed in every `RENEWED`-th row only."""
    kept = np.arange(len(table)) // RENEWED * RENEWED
    return table.assign(pressure_kPa=table["pressure_kPa"].to_numpy()[kept])


@pytest.mark.parametrize(("axis", "seed"), [("flexion", 611), ("deviation", 612)])
def test_the_rate_of_the_regulator_is_that_of_the_rig(tmp_path, axis, seed):
    rig = make_rig(axis, [], seed)
    record(rig, tmp_path, short=True)
    for log in tmp_path.glob("*.csv"):
        held(pd.read_csv(log)).to_csv(log, index=False, lineterminator="\n")
    fitted = fit_rig(load_campaign(tmp_path), built_in(axis), 1).fit.fitted.parameters
    truth = rig.declared._asdict()
    for name in ("gain", "k_fast", "k_slow"):
        found = fitted[name]
        assert abs(found.value - truth[name]) < 3.0 * found.provenance.std_error, name
    assert fitted["k_fast"].value == pytest.approx(truth["k_fast"], rel=0.02)


def test_a_clock_between_two_numbers_of_rows_is_told_by_its_mean():
    """0.1667 s in rows of 10 ms: 16 or 17 of them, none of which holds a renewal in between; with a pause."""
    campaign = load_campaign(EXAMPLE)
    r = campaign.fit[0]
    at = np.floor(np.arange(len(r.time)) * 0.01 / 0.1667 + 1e-9).astype(int)
    first = np.searchsorted(at, at)
    rng = np.random.default_rng(0)
    pressure = (r.pressure + rng.normal(0.0, 0.2, len(r.time)))[first]
    paused = np.where(np.arange(len(r.time)) > 700, r.time + 0.2, r.time)
    made, said = corrected(replace(campaign, fit=(replace(r, time=paused, pressure=pressure),), validate=()))
    np.testing.assert_array_equal(np.flatnonzero(made.fit[0].fresh("pressure_kPa")), np.unique(first))
    (remark,) = (x for x in said if x.habit == "held")
    assert remark.value == pytest.approx(0.1667, abs=4e-4)
