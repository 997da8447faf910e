"""The C of controllers for a plant of plays does what Python does; of function blocks: `test_export_st`."""

import pytest

from design.export.table import EXEMPLARY, PLAYS, difference_in_c, exemplary, of_plays
from design.export.vectors import vector
from tests.control.c_target import WRIST, needs_compiler

SECOND = of_plays(WRIST)
KNOW_THE_LOOP = ("feedforward", "feedforward-pi", "observer", *(k for k in EXEMPLARY if "mpc" in k))


@pytest.mark.slow
@needs_compiler
@pytest.mark.parametrize("kind", EXEMPLARY)
def test_c_replays_the_vector_of_a_plant_of_plays(kind):
    made = exemplary(kind, SECOND)
    assert difference_in_c(made, vector(made, SECOND, 1500)) <= made.tolerance


@pytest.mark.parametrize("kind", EXEMPLARY)
def test_who_knows_the_loop_remembers_its_plays(kind):
    plays = [f.name for f in exemplary(kind, SECOND).state if "plays" in f.name]
    assert bool(plays) == (kind in KNOW_THE_LOOP)
    assert len(plays) % len(PLAYS.v) == 0
