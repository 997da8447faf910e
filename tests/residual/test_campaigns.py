"""On the example campaigns, made by a simulator that shares no code with the project."""

from pathlib import Path

import numpy as np
import pytest

import plants.measured
from plants.measured.campaigns.campaign import load_campaign
from plants.measured.campaigns.playback import Playback
from plants.measured.fitting.fit import fit_campaign
from plants.measured.residual.examine import examine
from plants.measured.residual.series.remainder import remainder_of
from plants.parameters.files import built_in
from plants.wrist import Wrist

EXAMPLES = Path(plants.measured.__file__).parent / "examples"
CHANNEL = {"regulator": "pressure_kPa", "wrist": "angle_deg"}


@pytest.fixture(scope="module", params=["flexion", "deviation"])
def fit(request):
    return fit_campaign(load_campaign(EXAMPLES / request.param), built_in(request.param), starts=1)


def left(fit, stage):
    return [
        remainder_of(r.recording, stage, r.pressure, r.angle, fit.noise[CHANNEL[stage]]) for r in fit.runs
    ]


def test_a_wrist_that_lacks_nothing_leaves_noise_and_a_hum_is_named(fit):
    assert not examine(left(fit, "regulator")).structured
    wrist = examine(left(fit, "wrist"))
    if fit.campaign.axis == "flexion":
        assert not wrist.structured, wrist.findings[:3]
        assert wrist.ratio == pytest.approx(1.0, abs=0.03)
    else:
        assert len(wrist.depends_on) == 1
        assert wrist.depends_on[0].startswith("periodic at ")
        assert wrist.findings[0].share > 0.9


def test_parameters_off_by_twice_their_errors_leave_nothing_to_find(fit):
    if fit.campaign.axis == "deviation":
        pytest.skip("the hum is there anyway")
    rng = np.random.default_rng(1)
    errors = {n: getattr(p.provenance, "std_error", None) or 0.0 for n, p in fit.fitted.parameters.items()}
    assert sum(e > 0.0 for e in errors.values()) >= 8
    values = {n: v + 2.0 * errors[n] * rng.choice([-1.0, 1.0]) for n, v in fit.fitted.values.items()}
    wrist = Wrist.from_values(values)
    played = [(r, *Playback(r).play(wrist)) for r in (*fit.campaign.fit, *fit.campaign.validate)]
    for stage, channel in CHANNEL.items():
        found = examine([remainder_of(r, stage, p, a, fit.noise[channel]) for r, p, a in played])
        assert not found.structured, (stage, found.findings[:3])
