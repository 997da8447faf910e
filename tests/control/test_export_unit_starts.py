"""A unit that is set up as it comes is at rest: its law, begun from its starts, holds still there."""

import pytest

from design.export.catalogue import part
from design.export.formats.fmu import variables
from design.export.vectors import TargetReplay
from tests.control.c_target import GAINS, WRIST

KINDS = ["pi", "pi-2dof", "cascade", "lqi", "feedforward-pi", "observer", "mpc", "mpc-real-time"]


@pytest.mark.parametrize("kind", KINDS)
def test_the_starts_of_a_unit_are_the_wrist_at_rest(kind):
    made = part(kind, "flexion", WRIST, GAINS[kind])
    table = {v.name: v for v in variables(made)}
    assert [v.place for v in table.values()] == list(range(len(table)))
    at = {n: v.start for n, v in table.items() if v.start is not None}
    rest = WRIST.rest()
    assert at["start_pressure_kPa"] == pytest.approx(float(rest.pressure))
    assert at["start_angle_deg"] == pytest.approx(float(rest.angle))
    law = TargetReplay(made)
    held = law.begin(at["start_pressure_kPa"], at["start_angle_deg"])
    values = [0.0] * len(made.seen._fields)
    for place, quantity in made.read:
        values[place] = at[quantity.member]
    seen = made.seen(*values)
    for _ in range(50):
        assert law.step(seen) == pytest.approx(held, abs=1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_what_can_be_set_has_a_start_and_what_is_computed_has_none(kind):
    for v in variables(part(kind, "flexion", WRIST, GAINS[kind])):
        assert (v.start is not None) == (v.causality in ("parameter", "input"))
        assert (v.variability == "fixed") == (v.causality == "parameter")
