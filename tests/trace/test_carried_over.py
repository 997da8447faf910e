"""An effect is kept only where recordings that it was not fitted on are not simulated the worse for it."""

from dataclasses import replace

import numpy as np
import pytest

from plants.effects import Creep, Drift, LoadStep
from plants.measured.campaigns.playback import Playback
from plants.measured.campaigns.recording import Recording
from plants.measured.fitting.stage import Stage
from plants.measured.trace.ranking.excitation import excitation
from plants.measured.trace.search import choose
from plants.measured.trace.search.candidate import Candidate, carries_over
from plants.measured.trace.search.common import common_at_least, common_instead
from plants.measured.trace.search.refits import Scope, rather_common
from plants.measured.trace.search.simplify import carried_over
from plants.measured.trace.search.worth import worth_it
from plants.measured.trace.stages.model import Model
from plants.parameters.files import built_in
from plants.simulation.open_loop import open_loop
from plants.wrist import Wrist

DECLARED, NOISE = built_in("flexion"), 0.05
TIME = 0.01 * np.arange(3000)
FAST, SLOW = (2.0 + 1.2 * np.sin(w * TIME) for w in (1.5, 0.6))


def candidate(*effects, loads=(), rig=None, commands=(FAST, SLOW), sway=0.0):
    """A model with effects, fitted to a recording of each command; loads: deg of each after 12 s; sway [deg]:
    of a motion that nothing causes."""
    rng, found = np.random.default_rng(0), []
    wrist = Wrist.of(DECLARED) if rig is None else Wrist.of(DECLARED) + rig
    for i, command in enumerate(commands):
        angle = open_loop(wrist, np.repeat(command, 10)).angle[:-1:10]
        angle = angle + sway * np.sin(2.2 * TIME + i) + rng.normal(0.0, NOISE, TIME.size)
        angle += loads[i] * (TIME > 12.0) if loads else 0.0
        found.append(Playback(Recording(f"run{i}", TIME, command, angle=angle), DECLARED.rig.sample_time))
    stage = Stage("whole", "angle_deg", NOISE, tuple(found), ("a1", "a2"), DECLARED.rig)
    values = dict(DECLARED.values)
    for effect in effects:
        values |= effect.values
    return Candidate(Model(stage, DECLARED, values, tuple(map(type, effects))).fitted())


def test_what_happened_in_one_recording_alone_is_not_carried_over():
    found, without = (candidate(*e, loads=(3.0, -0.5)) for e in ((LoadStep(1.0, 11.9),), ()))
    assert found.model.chi2 < 0.9 * without.model.chi2  # it fits better, and says less
    assert carries_over(found, without)
    assert carried_over(found, without).model.effects == ()


def test_what_the_rig_has_is():
    found = candidate(Creep(0.1, 3.0), rig=Creep(0.15, 4.0))
    without = candidate(rig=Creep(0.15, 4.0))
    assert carried_over(found, without) is found
    assert found.over_recordings == pytest.approx(1.0, abs=0.05)
    assert carries_over(without, found)


def test_a_single_recording_says_nothing_of_it():
    found = candidate(LoadStep(1.0, 11.9), loads=(2.0,), commands=(FAST,))
    assert found.over_recordings is None
    without = candidate(loads=(2.0,), commands=(FAST,))
    assert carried_over(found, without) is found
    assert not carries_over(found, without)


def test_a_recording_beyond_the_range_of_the_others_is_not_held_against_a_model():
    small, large = 1.2 + 0.5 * np.sin(1.5 * TIME), 1.5 + 1.2 * np.sin(0.6 * TIME)
    alone, both = candidate(commands=(small,)), candidate(commands=(small, large))
    assert alone.over_recordings is None
    one, other = (both.model.stage.edges[i : i + 2] for i in (0, 1))
    left = both.model.fitted(rows=np.arange(2 * TIME.size) >= other[0]).residual[one[0] : one[1]]
    assert both.over_recordings == pytest.approx(float(np.sqrt(np.mean(left**2))))
    assert candidate(commands=(small, 1.1 * small - 0.12)).over_recordings is not None


def guessed(found):
    """The candidate where the law was chosen from the log."""
    return Candidate(replace(found.model, stage=replace(found.model.stage, form=0.05, guessed=True)))


def test_what_nearly_any_rig_has_comes_before_what_whole_recordings_bear_out_less():
    rig = Creep(0.2, 4.0)
    bare, creep, step = (candidate(*e, rig=rig) for e in ((), (Creep(0.1, 5.0),), (LoadStep(0.5, 9.0),)))
    assert carries_over(step, creep)
    first, second = rather_common(guessed(bare), [guessed(step), guessed(creep)])
    assert (first.model.effects, second.model.effects) == (("creep",), ("load-step",))
    declared = rather_common(bare, [step, creep])  # under a law that was given chi-square decides
    assert [c.model.effects for c in declared] == [("load-step",), ("creep",)]


def test_what_nearly_any_rig_has_comes_no_earlier_where_whole_recordings_do_not_say_so():
    bare, creep, step = (
        guessed(candidate(*e, loads=(0.5, 0.5))) for e in ((), (Creep(0.1, 5.0),), (LoadStep(0.5, 11.9),))
    )
    assert not carries_over(step, creep)
    assert rather_common(bare, [step, creep]) == [step, creep]


def test_what_nearly_any_rig_has_is_added_where_whole_recordings_bear_it_out_though_little_is_explained():
    """A rig with creep and something that no effect explains, by which most of the error is left."""
    made = {"rig": Creep(0.2, 4.0), "sway": 0.6}
    bare, creep = (guessed(candidate(*e, **made)) for e in ((), (Creep(0.1, 5.0),)))
    step = guessed(candidate(LoadStep(0.5, 9.0), **made))
    assert not worth_it(bare, creep, bare)
    taken = common_at_least(bare, [step, creep])
    assert taken.model.effects == ("creep",)
    assert common_at_least(bare, [step]) is None  # few rigs have it
    assert common_at_least(bare, [bare]) is None
    declared = Candidate(replace(bare.model, stage=replace(bare.model.stage, guessed=False)))
    assert common_at_least(declared, [creep]) is None  # of a law that was given


def drifting(rig):
    """A search's last model, of a drift of the sensor in one recording, and what the search may use."""
    bare, now = (guessed(candidate(*e, rig=rig, commands=(SLOW,))) for e in ((), (Drift(0.01),)))
    asked = excitation(now.model.stage.playbacks)
    return Scope(bare, ("creep", "gyro-drift"), asked, 0, lambda _: None), now


def test_a_drift_that_stands_for_what_creeps_is_replaced():
    scope, now = drifting(Creep(0.2, 4.0))
    exchange = common_instead(scope, now)
    assert exchange.before is now
    assert exchange.taken.model.effects == ("creep",)
    assert exchange.taken.model.chi2 < now.model.chi2


def test_a_drift_that_the_data_tells_from_creep_stays():
    scope, now = drifting(Drift(0.2))
    exchange = common_instead(scope, now)
    assert exchange.taken is None
    assert all(c.model.chi2 > now.model.chi2 for c in exchange.candidates)


def test_what_nearly_any_rig_has_is_not_put_in_the_place_of_an_effect_under_a_law_that_was_given():
    scope, now = drifting(Creep(0.2, 4.0))
    given = Candidate(replace(now.model, stage=replace(now.model.stage, guessed=False)))
    assert common_instead(scope, given) is None
    creeping = guessed(candidate(Creep(0.1, 5.0), rig=Creep(0.2, 4.0), commands=(SLOW,)))
    assert common_instead(scope, creeping) is None


def test_a_search_whose_rules_disagree_ends(monkeypatch):
    """Of a vacuum actuator a dead time was added, which leaves a fifth, and taken away again for ever, since
    that is a trifle of what the valves had brought."""
    bare = candidate(rig=Creep(0.15, 4.0))
    monkeypatch.setattr(choose, "pruned", lambda now, declared: declared)
    found = choose.search(bare.model, ("creep",))
    assert found.chosen.model.effects == ("creep",)
