"""A rig may be measured in any units: in others the same wrist does the same, with every form of an effect.

A number of the paper's wrist that is left in a law or an effect shows as a difference.
"""

from dataclasses import replace

import numpy as np
import pytest

from plants import Wrist, built_in
from plants.rig import Units, built_in_rig
from plants.simulation.open_loop import open_loop
from tests.design.effect_samples import FORMS, IDS, present

COMMAND, PRESSURE, ANGLE = 1000.0, 0.01, 0.3
"""A command in mV, a pressure in bar, an angle as a way on a string of 0.3 mm a degree."""

OWN = built_in_rig()
RIG = replace(
    OWN,
    units=Units("mV", "bar", "mm"),
    command_range=tuple(COMMAND * v for v in OWN.command_range),
    pressure_range=tuple(PRESSURE * p for p in OWN.pressure_range),
    task=replace(OWN.task, step=ANGLE * OWN.task.step),
)


def turned(values: dict[str, float], units: dict[str, str]) -> dict[str, float]:
    """Values by name in the units of the other rig."""
    return {n: RIG.scaled(v, units[n]) for n, v in values.items()}


@pytest.mark.parametrize(
    ("unit", "factor"),
    [
        ("kPa/V", PRESSURE / COMMAND), ("deg/kPa", ANGLE / PRESSURE), ("1/deg", 1.0 / ANGLE), ("deg", ANGLE),
        ("deg s/kPa", ANGLE / PRESSURE), ("kPa/s", PRESSURE), ("s", 1.0), ("Hz", 1.0), ("1", 1.0),
    ],
)  # fmt: skip
def test_a_unit_says_by_how_much_a_number_changes(unit, factor):
    assert RIG.scaled(3.0, unit) == pytest.approx(3.0 * factor, rel=1e-12)
    assert OWN.scaled(3.0, unit) == 3.0


@pytest.mark.parametrize("form", FORMS, ids=IDS)
def test_the_same_wrist_in_other_units_does_the_same(form):
    own = built_in("flexion")
    wrist = Wrist.of(own) + present(form)
    units = {n: k.unit for n, k in own.kinds.items()}
    units |= {f"{form.NAME}.{n}": k.unit for n, k in form.kinds().items()}
    there = Wrist.from_values(turned(wrist.values, units), (form,), RIG)
    volts = 2.0 + 1.7 * np.sin(np.arange(6000) * 2e-3)
    volts[2000:3000] = 3.6
    kpa = 100.0 + 40.0 * np.sin(np.arange(6000) * 1e-3)
    one = open_loop(wrist, volts, other_pressure=kpa)
    other = open_loop(there, COMMAND * volts, other_pressure=PRESSURE * kpa)
    np.testing.assert_allclose(other.pressure / PRESSURE, one.pressure, rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(other.angle / ANGLE, one.angle, rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("form", FORMS, ids=IDS)
def test_trials_are_those_of_the_rig(form):
    kinds = form.kinds()
    for own, there in zip(form.trials(), form.trials(RIG), strict=True):
        assert there == pytest.approx({n: RIG.scaled(v, kinds[n].unit) for n, v in own.items()})
