"""Logs of a closed loop whose set-points change on rows are fitted as those of an open loop: the noise that
the controller feeds back biases nothing, since the fit runs freely from the logged command."""

import numpy as np
import pytest

from plants.measured.campaign import load_campaign
from plants.measured.fit import fit_campaign
from plants.parameters.files import built_in
from tests.rig.campaign import logged_table, make_rig
from tests.rig.core import Controller


def record(rig, folder, name, salt):
    """A minute under a PI that sees the noise, to random set-points held for 1 to 4 s."""
    rng = np.random.default_rng([rig.seed, salt])
    edges = np.round(np.cumsum(rng.uniform(1.0, 4.0, 60)), 2)
    levels = np.append(0.0, rng.uniform(-14.0, 14.0, 60))
    asked = levels[np.searchsorted(edges, np.arange(60_001) * 0.001 + 1e-6)]
    run = rig.follow(asked, Controller(4.28, 10.4), salt)
    logged_table(rig, "task", run, False).to_csv(folder / f"{name}.csv", index=False)


@pytest.mark.suite
def test_parameters_lie_within_their_errors(tmp_path):
    rig = make_rig("flexion", [], 402)
    for salt, name in enumerate(("one", "two", "three")):
        record(rig, tmp_path, name, 11 + salt)
    (tmp_path / "campaign.toml").write_text(
        'axis = "flexion"\nsample_time_s = 0.01\nfit = ["one.csv", "two.csv"]\nvalidate = ["three.csv"]\n'
    )
    fit = fit_campaign(load_campaign(tmp_path), built_in("flexion"), 1)
    assert max(fit.ratios.values()) < 1.05
    truth = rig.declared._asdict()
    for name, p in fit.fitted.parameters.items():
        error = getattr(p.provenance, "std_error", None)
        if error is not None:
            assert abs(p.value - truth[name]) < max(4.0 * error, 0.005 * abs(truth[name])), name
