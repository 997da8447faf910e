"""Cases are drawn independently and uniformly, start at rest holding their load, and know their reach."""

import numpy as np
import pytest
from scipy import stats

from design.controllers.pi import PI
from design.evaluation import steps as loop
from design.robustness.box import Box, box_of
from design.robustness.intervals import Interval
from design.robustness.requirement import requirement, requirement_record
from design.robustness.samples.conditions import NONE, Conditions
from design.robustness.samples.draws import CHUNK, SamplingTask, draw
from design.robustness.samples.monte_carlo import monte_carlo, samples_record
from plants.effects.regulator.dead_time import DeadTime
from plants.effects.wrist.creep import Creep
from plants.effects.wrist.end_stop import HardStop
from plants.kernel import pytrees as tree
from plants.parameters.files import built_in

FLEXION = built_in("flexion")
TUNED = PI(5.0, 9.0)
SLOPES = Interval("slopes", 0.8, 1.0, 1.2, "1", "the test's", ("a1", "a2", "s"))


def test_cases_are_independent_and_uniform():
    n, box = 6 * CHUNK, box_of(FLEXION)
    task = SamplingTask(box, TUNED, Conditions(0.05, 1.0, 0.0, 0.0), 12, 15.0, 10.0)
    cases = [draw(task, k) for k in range(6)]
    values = {x: np.concatenate([c.values[x] for c in cases]) for x in cases[0].values}
    ends = {i.name: (i.low, i.high) for i in box.intervals} | {"dead_time": (0.0, 0.05), "load": (-1.0, 1.0)}
    assert values.keys() == ends.keys()
    shares = np.array([(v - ends[x][0]) / (ends[x][1] - ends[x][0]) for x, v in values.items()])
    start = np.concatenate([c.start for c in cases])
    sign = np.concatenate([np.sign(c.reference) for c in cases])
    assert all(stats.kstest(row, "uniform").pvalue > 1e-4 for row in shares)
    table = np.array([[np.sum((start == s) & (sign == d)) for s in range(4)] for d in (-1, 1)])
    assert stats.chisquare(table.ravel()).pvalue > 1e-4
    assert np.unique(shares).size == shares.size  # nothing drawn twice, in no chunk
    rows = np.vstack([shares, start, sign])
    between = np.corrcoef(rows) - np.eye(len(rows))
    assert np.abs(between).max() < 4.5 / np.sqrt(n)
    for lag in (1, 16, CHUNK):  # neighbours, lanes of a block, the same place in the next chunk
        later = np.corrcoef(rows[:, :-lag], rows[:, lag:])
        assert np.abs(later[: len(rows), len(rows) :]).max() < 4.5 / np.sqrt(n - lag)


@pytest.mark.parametrize("effects", [(), (Creep,)], ids=["declared", "creeping"])
def test_every_case_starts_at_rest_holding_its_load(effects):
    plant = FLEXION.revised(
        effects, {"creep.gain": 0.1, "creep.time_constant": 4.0} if effects else {}, {}, "x"
    )
    box = Box(plant, (SLOPES,))
    task = SamplingTask(box, PI(0.0, 0.0), Conditions(0.05, 2.0, 0.0, 0.0), 1, 15.0, 3.0)
    cases = draw(task, 0, 96)
    _, last, _ = loop.run(cases.wrist, task.controller, cases.reference, cases.state, duration=3.0)
    np.testing.assert_allclose(last.plant.angle, cases.state.angle, atol=1e-6)
    virgin = cases.start == 0
    np.testing.assert_allclose(cases.state.angle[~virgin], 0.0, atol=1e-12)
    sag = cases.values["load"] * (1.1 if effects else 1.0)
    np.testing.assert_allclose(cases.state.angle[virgin], sag[virgin], atol=0.25 if effects else 1e-12)


def test_the_closed_form_of_the_rest_is_what_the_search_finds():
    """A declared plant's rest is written down; one whose effects vanish is looked for."""
    plant = FLEXION.revised((Creep,), {"creep.gain": 0.0, "creep.time_constant": 4.0}, {}, "x")
    conditions = Conditions(0.05, 2.0, 0.0, 0.0)
    found, sought = (
        draw(SamplingTask(Box(p, (SLOPES,)), TUNED, conditions, 1, 15.0, 3.0), 0, 200)
        for p in (FLEXION, plant)
    )
    for a, b in zip(tree.leaves(found.state[:3]), tree.leaves(sought.state[:3]), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-8)
    np.testing.assert_array_equal(found.out_of_reach, sought.out_of_reach)


STOP = {"high": 10.0, "low": -40.0}


def test_an_end_stop_puts_its_side_out_of_reach():
    form = HardStop
    values = {f"end-stop.{n}": v for n, v in STOP.items()}
    plant = FLEXION.revised((form,), values, {}, "x")
    found = monte_carlo(Box(plant, (SLOPES,)), TUNED, NONE, 48, duration=0.2)
    np.testing.assert_array_equal(found.out_of_reach, found.reference > 0.0)


def test_a_dead_time_of_the_plants_own_counts_towards_the_longest():
    """A tube of 12 ms that was traced leaves 38 of 50 ms: the longest loop has 50 ms, as any plant's."""
    plant = FLEXION.revised((DeadTime,), {"dead-time.delay": 0.012}, {}, "x")
    found = monte_carlo(Box(plant, (SLOPES,)), TUNED, Conditions(0.05, 1.0, 0.0, 0.0), 512, duration=0.2)
    assert found.remarks == ()
    assert found.drawn["dead_time"].min() < 0.001
    assert 0.037 < found.drawn["dead_time"].max() <= 0.038
    assert requirement(plant).space.dead_time == pytest.approx(0.038)
    assert requirement_record(requirement(plant))["longest_dead_time_s"] == pytest.approx(0.05)


def test_a_dead_time_of_the_plants_own_beyond_the_longest_stays_and_is_said():
    plant = FLEXION.revised((DeadTime,), {"dead-time.delay": 0.08}, {}, "x")
    found = monte_carlo(Box(plant, (SLOPES,)), TUNED, Conditions(0.05, 1.0, 0.0, 0.0), 32, duration=0.2)
    assert found.remarks == ("dead_time: the plant has its own dead-time",)
    assert set(found.drawn) == {"slopes", "load"}
    assert samples_record(found)["left_out"] == list(found.remarks)
