"""Counted from elsewhere a plant is the same one: it simulates what it did, less an angle."""

from dataclasses import replace

import numpy as np
import pytest

from plants.effects import EFFECTS
from plants.hysteresis import PrandtlIshlinskii
from plants.measured.campaigns.begin import Begin
from plants.measured.campaigns.campaign import Campaign
from plants.measured.campaigns.recording import Recording
from plants.measured.fitting.stage import begun
from plants.measured.trace.counting.middle import about_middle, counted_elsewhere
from plants.parameters.correlation import matrix_of
from plants.parameters.files import built_in
from plants.parameters.quantities import Fitted, Parameter, ParameterSet, in_units
from plants.wrist import Wrist

LOOP = PrandtlIshlinskii(
    0.06, (0.1, 0.15, 0.05), 18.0, span=6.0, c1=0.6, c2=1.3, b1=1.2, b2=0.9, rest_pressure=20.0, centre=8.0
)
MOVED = [f for forms in EFFECTS.values() for f in forms if not f.FROM_REST]
TOGETHER = tuple(EFFECTS[n][0] for n in ("dead-time", "softening", "creep", "end-stop"))
BY = 9.0


def plant(forms=(), loop=LOOP):
    """A parameter set of a rig that bends to one side, of a loop and effects at the last of their trials."""
    declared = built_in("flexion")
    values = {n: v for n, v in declared.values.items() if n in ("gain", "k_fast", "k_slow", "e0", "Tw")}
    values |= loop.values
    for form in forms:
        values |= form(**list(form.trials())[-1]).values
    # Kinds are of the names alone.
    named = replace(declared, parameters={n: Parameter(v, "", v, v, None) for n, v in values.items()})
    kinds = {n: in_units(k, declared.rig) for n, k in replace(named, effects=tuple(forms)).kinds.items()}
    found = {
        n: Parameter(float(values[n]), k.unit, k.low, k.high, Fitted("a test", None))
        for n, k in kinds.items()
    }
    return ParameterSet("flexion", "a test", found, tuple(forms), declared.rig)


def test_every_effect_says_whether_it_counts_from_rest():
    from_rest = {f.NAME for forms in EFFECTS.values() for f in forms if f.FROM_REST}
    assert from_rest == {"branch-curvature", "loop-shape", "inertia"}


@pytest.mark.parametrize(
    "forms", [*((f,) for f in MOVED), TOGETHER], ids=lambda fs: ", ".join(f"{f.NAME} {f.FORM}" for f in fs)
)
def test_it_simulates_what_it_did(forms):
    before = plant(forms)
    after = counted_elsewhere(before, BY)
    assert after.rig.zero.angle == BY
    assert after.rig.zero.rest == -BY
    wrists = [Wrist.of(p) for p in (before, after)]
    time = np.arange(6000)
    command = np.maximum(2.0 + 1.8 * np.sin(time / 900.0) * np.sin(time / 230.0), 0.2)
    one, other = (
        w.simulate(command, begun(w, Begin(20.0, -by, True, -by)))
        for w, by in zip(wrists, (0.0, BY), strict=True)
    )
    np.testing.assert_allclose(other.angle, one.angle - BY, atol=1e-9)
    np.testing.assert_array_equal(other.pressure, one.pressure)
    assert np.ptp(one.angle) > 8.0


@pytest.mark.parametrize("name", ["branch-curvature", "loop-shape"])
def test_what_counts_from_rest_is_not_moved(name):
    assert counted_elsewhere(plant((EFFECTS[name][0],)), BY) is None


def test_four_segments_are_not_moved():
    """Their initial curve begins at one angle."""
    assert counted_elsewhere(built_in("flexion"), BY) is None


def test_errors_are_those_of_the_same_estimates():
    """Of a straight curve the pressure that holds the angle is rest + angle / sum of the weights."""
    straight = PrandtlIshlinskii(0.1, (0.2,), 18.0, rest_pressure=20.0)
    known = plant(loop=straight)
    errors = {"v0": 0.01, "v1": 0.02, "rest_pressure": 0.5}
    of = {n: replace(p, provenance=Fitted("a test", errors.get(n))) for n, p in known.parameters.items()}
    told = replace(known, parameters=of, correlation={"v1": {"v0": -0.6}})
    moved = counted_elsewhere(told, BY)
    names = list(errors)
    size = np.array(list(errors.values()))
    drawn = np.random.default_rng(0).multivariate_normal(
        [told.values[n] for n in names], matrix_of(told.correlation, names) * size * size[:, None], 200_000
    )
    drawn[:, 2] += BY / (drawn[:, 0] + drawn[:, 1])
    assert moved.values["rest_pressure"] == pytest.approx(20.0 + BY / 0.3)
    found = [moved.parameters[n].provenance.std_error for n in names]
    np.testing.assert_allclose(found, drawn.std(axis=0), rtol=0.05)
    matrix = matrix_of(moved.correlation, names)
    np.testing.assert_allclose(matrix, np.corrcoef(drawn.T), atol=0.03)


def log(low, high):
    time = np.linspace(0.0, 10.0, 200)
    angle = low + (high - low) * (0.5 - 0.5 * np.cos(time))
    recording = Recording("one", time, np.full(200, 2.0), angle)
    return Campaign("a campaign", "flexion", "wrist", "rest", 0.05, (recording,), (recording,), "")


def test_a_declared_rig_stays_where_it_holds_its_steps():
    """As one with two muscles whose log happens to show one side alone."""
    both = plant(loop=replace(LOOP, rest_pressure=100.0))
    assert about_middle(both, log(0.0, 30.0), guessed=False) is both
    assert about_middle(both, log(0.0, 30.0), guessed=True).rig.zero.angle == 15.0
    assert about_middle(both, log(-30.0, 30.0), guessed=True) is both


def test_a_declared_rig_that_bends_to_one_side_is_moved():
    aside = plant(loop=replace(LOOP, rest_pressure=0.0))
    moved = about_middle(aside, log(0.0, 40.0), guessed=False)
    assert moved.rig.zero.angle == 20.0
    assert 0.0 < moved.rig.task.step <= 15.0
