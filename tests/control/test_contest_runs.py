"""A run of the contest is what a plain loop, sample by sample, makes of the same case."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from design.contest import coupled
from design.contest.coupled import run_coupled
from design.contest.periodic import play_coupled
from design.contest.plants import carrying, nominal
from design.contest.play import METRICS, lanes_for, told
from design.controllers.pi import PI
from design.controllers.pi import step as pi_step
from design.evaluation.runner import play
from design.evaluation.steps import run as plain_run
from design.evaluation.tasks import lasts, side_by_side, stairs
from design.robustness.samples.conditions import Conditions
from plants import InputError, Wrist
from plants import dynamics as plant
from plants.effects import Creep
from plants.effects.effect import Around
from plants.effects.wrist.cross_coupling import Coupling
from plants.effects.wrist.load_step import LoadStep

WRIST = Wrist.flexion()
RIG = WRIST.rig
DURATION = lasts("side by side", RIG)
GAINS = PI(3.0, 10.0)
QUIET = Conditions(0.0, 0.0, 0.0, 0.0)
NOISY = Conditions(0.0, 0.0, 0.07, 0.01)


def lanes(asked, conditions, wrist=WRIST, **effects):
    field = nominal(wrist)
    field = replace(field, wrist=field.wrist.with_values(**{n: np.array([v]) for n, v in effects.items()}))
    return lanes_for(field, [0] * len(asked), asked, conditions, seed=3, chunk=0)


def run(asked, controller):
    return SimpleNamespace(**told(play(asked, controller)))


def short(asked):
    """The tasks for 1.3 s: where every sample is a period, a run is slow."""
    found = []
    for t in asked:
        n = sum(begin < 1.3 for _, begin, _ in t.stages)
        holds = (*t.holds[: n - 1], 1.3 - sum(t.holds[: n - 1]))
        found.append(replace(t, references=t.references[:n], holds=holds, counted=min(t.counted, n)))
    return found


def plainly(wrist, state, reference_at):
    """Angles, commands and pressures of a plain loop with a perfect sensor."""
    c, held, gains = wrist.sampled(), GAINS.holding(state.pressure), GAINS.sampled()
    rows = []
    for k in range(round(DURATION * 1000)):
        held, command = pi_step(held, reference_at(k) - state.angle, gains)
        rows.append((float(state.angle), float(command), float(state.pressure)))
        state = plant.step(state, command, c, Around(k * 1e-3))
    return np.array(rows).T


def test_a_step_is_judged_as_the_loop_of_the_comparison_judges_it():
    steps = [t for t in side_by_side(RIG) if t.family == "steps"]
    found = run(lanes(steps, QUIET), GAINS)
    for lane, t in enumerate(steps):
        judged, _, _ = plain_run(WRIST, GAINS, t.references[0], WRIST.rest(t.start), duration=DURATION)
        assert found.iae_deg_s[lane] == pytest.approx(float(judged.iae_deg_s[0]), rel=1e-6)
        assert found.settling_time_s[lane] == pytest.approx(float(judged.settling_time_s[0]), abs=1.5e-3)
        assert found.overshoot_percent[lane] == pytest.approx(float(judged.overshoot_percent[0]), abs=1e-5)
        assert found.total_variation_V[lane] == pytest.approx(float(judged.total_variation_V[0]), rel=1e-5)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_staircase_is_judged_stair_by_stair(sign):
    asked = [t for t in side_by_side(RIG) if t.family == "staircase" and t.references[0] * sign > 0.0]
    found = run(lanes(asked, QUIET), GAINS)
    treads = sign * np.array(stairs(RIG))
    held = round(1000 * lasts("tread", RIG))
    angle, command, pressure = plainly(WRIST, WRIST.rest(), lambda k: treads[k // held])
    error = np.abs(angle - np.repeat(treads, held))
    assert found.iae_deg_s[0] == pytest.approx(error.sum() * 1e-3, rel=1e-6)
    assert found.total_variation_V[0] == pytest.approx(
        np.abs(np.diff(command, prepend=100.0 / 49.4)).sum(), rel=1e-5
    )
    assert found.pressure_travel_kPa[0] == pytest.approx(np.abs(np.diff(pressure)).sum(), rel=1e-3)
    outside = [np.flatnonzero(part >= 0.3) for part in error.reshape(len(treads), held)]
    assert all(part[-1] + 1 < held for part in outside)
    assert found.unsettled[0] == 0.0
    assert found.settling_time_s[0] == pytest.approx(max(p[-1] + 1 for p in outside) * 1e-3, abs=1.5e-3)


def test_a_stair_that_is_not_settled_counts_as_the_whole_window():
    asked = [t for t in side_by_side(RIG) if t.family == "staircase"]
    found = run(lanes(asked, QUIET), PI(1.2, 2.2))
    assert found.unsettled.tolist() == [1.0, 1.0]
    assert found.settling_time_s.tolist() == [DURATION, DURATION]


def test_a_load_counts_from_when_it_comes():
    asked = [t for t in side_by_side(RIG) if t.family == "load step"]
    found = run(lanes(asked, QUIET), GAINS)
    for lane, t in enumerate(asked):
        loaded = WRIST + LoadStep(t.load, 1.0)
        rest = WRIST.rest(t.start, t.angle)
        state = loaded.rest()._replace(pressure=rest.pressure, memory=rest.memory, angle=rest.angle)
        angle, _, _ = plainly(loaded, state, lambda k, r=t.references[0]: r)
        error = np.abs(angle - t.references[0])[1000:]
        assert found.iae_deg_s[lane] == pytest.approx(error.sum() * 1e-3, rel=1e-5)
        last = np.flatnonzero(error >= 0.3)[-1] + 1
        assert found.settling_time_s[lane] == pytest.approx(last * 1e-3, abs=1.5e-3)


class EverySample:
    """The PI as a controller that acts once a period, of one sample."""

    problem = SimpleNamespace(substeps=1)

    def init(self, seen):
        held = GAINS.holding(seen.pressure)
        return SimpleNamespace(command=float(GAINS.command(held)), held=held)

    def step(self, state, seen):
        held, command = GAINS.sampled().act(state.held, seen)
        return SimpleNamespace(command=float(command), held=held), float(command), None


def test_a_controller_that_is_played_by_periods_meets_the_same_cases():
    asked = [next(t for t in side_by_side(RIG) if t.family == f) for f in ("steps", "staircase", "load step")]
    case = lanes(short(asked), NOISY, **{"dead-time.delay": 0.0503, "creep.gain": 0.1})
    one = run(case, GAINS)
    other = run(case, EverySample())
    for name in METRICS:
        np.testing.assert_allclose(getattr(other, name), getattr(one, name), rtol=1e-6, atol=1e-9)


def test_the_last_period_is_cut_short_where_periods_do_not_divide_the_window():
    """What comes after the window changes nothing of it."""
    seventh = EverySample()
    seventh.problem = SimpleNamespace(substeps=7)
    case = lanes(side_by_side(RIG)[:1], QUIET)
    longer = replace(case, duration=case.duration + (7 - case.samples % 7) * case.dt)
    assert case.samples % 7 > 0 == longer.samples % 7
    short, whole = (play(c, seventh, signals=("plant.angle", "plant.pressure")).rows for c in (case, longer))
    assert short.shape[1] == case.samples + 1
    np.testing.assert_array_equal(short, whole[:, : case.samples + 1])


def test_coupled_motions_do_what_two_wrists_in_one_loop_do():
    others, gain = (WRIST, Wrist.deviation()), 0.02
    asked = side_by_side(RIG)[:1]
    case = tuple(lanes(asked, QUIET, w, **{"cross-coupling.gain": gain}) for w in others)
    found, turns = run_coupled((GAINS, GAINS), case)
    assert turns > 2
    wrists = [w + Coupling(gain) for w in others]
    c, states, pis = [w.sampled() for w in wrists], [w.rest() for w in wrists], GAINS.sampled()
    held, iae = [GAINS.holding(s.pressure) for s in states], np.zeros(2)
    for k in range(round(DURATION * 1000)):
        pressures = [s.pressure for s in states]
        for me in (0, 1):
            iae[me] += abs(15.0 - states[me].angle) * 1e-3
            held[me], command = pi_step(held[me], 15.0 - states[me].angle, pis)
            states[me] = plant.step(states[me], command, c[me], Around(k * 1e-3, pressures[1 - me] - 100.0))
    assert [float(r.metrics.iae_deg_s[0]) for r in found] == pytest.approx(iae.tolist(), rel=1e-6)
    alone = [float(run(lanes(asked, QUIET, w), GAINS).iae_deg_s[0]) for w in others]
    assert abs(iae[0] - alone[0]) > 1e-2  # the coupling is felt


@pytest.mark.slow
def test_coupled_motions_that_are_played_by_periods_do_the_same():
    others, asked = (WRIST, Wrist.deviation()), side_by_side(RIG)[:2]
    case = tuple(lanes(short(asked), NOISY, w, **{"cross-coupling.gain": 0.02}) for w in others)
    together, _ = run_coupled((GAINS, GAINS), case)
    by_periods = play_coupled((EverySample(), EverySample()), case)
    for one, other in zip(together, by_periods, strict=True):
        for name in METRICS:
            np.testing.assert_allclose(told(other)[name], told(one)[name], rtol=1e-6, atol=1e-9)


def test_a_wrist_with_effects_of_its_own_is_refused():
    with pytest.raises(InputError, match=r"effects \(creep\) of its own"):
        carrying(WRIST + Creep(0.1), 1)


@pytest.mark.parametrize(("last", "turns"), [(0.99e-6, 3), (1.01e-6, 4)])
def test_turns_end_where_no_pressure_changes_by_a_millionth(monkeypatch, last, turns):
    """The pressures of one motion change from turn to turn: by 1e-3, by `last`, not at all."""
    levels = {1: iter((0.0, 1e-3, 1e-3 + last, 1e-3 + last)), 2: iter((0.0,) * 4)}

    def rows(lanes, who, **_):
        return SimpleNamespace(rows=[np.full((3, 1), next(levels[who]))])

    monkeypatch.setattr(coupled, "play", rows)
    both = SimpleNamespace(other_pressure=None)
    monkeypatch.setattr(coupled, "replace", lambda lanes, **_: lanes)
    assert run_coupled((1, 2), (both, both))[1] == turns
