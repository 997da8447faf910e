"""Gains that hold the requirement hold on simulated rigs with a dead time that their model lacks.

The rig is the tests' own: another integrator, finer steps, nothing shared with the project.
"""

from dataclasses import replace

import pytest

from design.robustness.requirement import requirement
from design.robustness.tuning.robust_tuning import tune_robustly
from design.synthesis.requirements import default_problem
from design.synthesis.tuning import Region, tune
from plants.parameters.files import built_in
from plants.parameters.quantities import Fitted
from plants.wrist import Wrist
from tests.rig.campaign import make_rig

LATE = 0.05


def rig_and_plant(axis, seed):
    """A rig with 50 ms of dead time, and the plant that a perfect fit without one would find."""
    rig = make_rig(axis, ["dead-time"], seed, {"dead-time": 1})
    dead = type(rig.hidden.dead_time)(transport_s=LATE)
    rig = replace(rig, hidden=rig.hidden._replace(dead_time=dead))
    plant = built_in(axis)
    values = rig.declared._asdict()
    fitted = {
        n: replace(p, value=values[n], provenance=Fitted("the rig's own", 0.002 * abs(values[n])))
        for n, p in plant.parameters.items()
    }
    return rig, replace(plant, parameters=fitted)


@pytest.mark.suite
@pytest.mark.parametrize(("axis", "seed"), [("flexion", 3), ("deviation", 4)])
def test_the_step_holds_on_the_rig_where_that_of_plain_gains_does_not(axis, seed):
    rig, plant = rig_and_plant(axis, seed)
    found = tune_robustly(requirement(plant), Region(points=20), 0)
    assert found.holds
    v = plant.values
    for reference in (15.0, -15.0):
        result = rig.closed_loop(
            found.final.Kp, found.final.Ki, reference, gain=v["gain"], rest_pressure=v["rest_pressure"]
        )
        assert result.overshoot <= 0.05
        assert result.settling < 5.0
        assert not result.oscillates
    bold = tune(default_problem(Wrist.of(plant)), Region(points=20), 1)
    worst = max(
        rig.closed_loop(bold.Kp, bold.Ki, r, gain=v["gain"], rest_pressure=v["rest_pressure"]).overshoot
        for r in (15.0, -15.0)
    )
    careful = max(
        rig.closed_loop(
            found.final.Kp, found.final.Ki, r, gain=v["gain"], rest_pressure=v["rest_pressure"]
        ).overshoot
        for r in (15.0, -15.0)
    )
    assert careful < worst
