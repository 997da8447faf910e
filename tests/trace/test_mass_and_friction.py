"""A joint with a mass and friction is named with both, and both are found as they are.

The rig is `tests.rig`: LuGre's bristles on a joint of second order, by Heun's method.  The law of the
friction had taken the place of that of the mass, so that neither was found beside the other.
"""

import pytest

from plants.measured.campaigns.campaign import load_campaign
from plants.measured.trace.trace import trace_campaign
from tests.rig.campaign import make_campaign


@pytest.mark.slow
@pytest.mark.parametrize(("axis", "seed"), [("flexion", 2), ("deviation", 3)])
def test_mass_and_bristles_are_found_together(tmp_path, axis, seed):
    forms = {"inertia": 1, "stick-slip": 2}
    rig = make_campaign(tmp_path, axis, tuple(forms), seed, forms)
    trace = trace_campaign(load_campaign(tmp_path))
    assert [(e.name, e.form) for e in trace.effects] == [
        ("inertia", "linear damping"),
        ("stick-slip", "bristles"),
    ]
    assert trace.after["angle_deg"] < 1.15 * trace.noise["angle_deg"]
    v, stick = trace.revised.values, rig.hidden.stick
    assert 1.0 / v["inertia.inertia"] == pytest.approx(rig.hidden.inertia.wn, rel=0.02)
    assert v["stick-slip.breakaway"] == pytest.approx(stick.breakaway, rel=0.1)
    friction = v["stick-slip.sliding"] * v["stick-slip.breakaway"]
    assert friction == pytest.approx(stick.coulomb, rel=0.1)
