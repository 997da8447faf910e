"""Gains that held their tuning and break a limit in their check are tuned again from the cases that do."""

from types import SimpleNamespace

import pytest

from design.controllers.pi import PI
from design.robustness.checks import broken_cases, check, worst_of
from design.robustness.requirement import requirement
from design.robustness.tuning.recommended import PLAIN, TWO_DOF
from design.robustness.tuning.robust_tuning import tune_robustly
from design.studies import confirmed as room
from design.studies.decision import AGAIN, of_check
from design.studies.designs import DesignEffort
from design.studies.stages import Stages
from plants.parameters.files import built_in

ASKED = requirement(built_in("flexion"))
EFFORT = DesignEffort(samples=10, runs=10)


def record(Kp, holds=True):
    gains = {"Kp": Kp, "Ki": 4.0, "b": 1.0, "Tf": 0.0}
    return {"gains": gains, "holds": holds, "cost": 9.0, "guard": {"overshoot_percent": 0.1}}


def designs(Kp, holds=True):
    return {PLAIN: record(Kp, holds), TWO_DOF: record(Kp, holds)}


@pytest.fixture
def run(monkeypatch):
    """What `confirmed` finds where gains, by Kp, break so many limits; and what was done."""

    def made(broken, tunings):
        done = SimpleNamespace(checked=[], cases=[])

        def checked(required, controller, samples, runs, seed, jobs, tell):
            done.checked.append((float(controller.Kp), seed))
            return {
                "samples": {"broken": 0}, "worst_case": {"broken": broken[float(controller.Kp)]},
                "linear_excess": {},
            }  # fmt: skip

        def tuned(required, effort, seed, jobs, tell, cases):
            assert not effort.alternatives
            done.cases.append(cases)
            return {**tunings.pop(0), "relaxed": None}

        monkeypatch.setattr(room, "checked", checked)
        monkeypatch.setattr(room, "tuned_designs", tuned)
        monkeypatch.setattr(room, "broken_cases", lambda required, c, *rest: (f"breaks {float(c.Kp):g}",))
        first = designs(2.0) | {"cascade": record(9.0)}
        evidence, found = room.confirmed(
            "flexion", ASKED, first, {}, Stages(None), EFFORT, 0, 1, lambda s, h: None
        )
        return evidence["worst_case"]["broken"], found, done

    return made


def test_gains_that_their_check_confirms_stay(run):
    broken, found, done = run({2.0: 0}, [])
    assert (broken, found[PLAIN]["gains"]["Kp"], done.cases) == (0, 2.0, [])


def test_gains_that_break_a_limit_are_tuned_again_and_checked_with_another_seed(run):
    broken, found, done = run({2.0: 177, 1.8: 0}, [designs(1.8)])
    assert (broken, found[PLAIN]["gains"]["Kp"]) == (0, 1.8)
    assert found["cascade"]["gains"]["Kp"] == 9.0  # what else was designed stays
    assert done.cases == [("breaks 2",)]
    assert done.checked == [(2.0, 0), (1.8, 1)]


def test_a_tuning_that_no_longer_holds_changes_nothing(run):
    broken, found, _ = run({2.0: 3, 1.8: 0}, [designs(1.8, holds=False)])
    assert (broken, found[PLAIN]["gains"]["Kp"]) == (3, 2.0)


def test_it_ends(run):
    always = {2.0 - 0.1 * k: 1 for k in range(9)}
    broken, _, done = run(always, [designs(2.0 - 0.1 * k) for k in range(1, 9)])
    assert (broken, len(done.checked), len(done.cases)) == (1, AGAIN + 1, AGAIN)
    assert len({of_check("flexion", k) for k in range(AGAIN + 1)}) == AGAIN + 1


@pytest.mark.slow
def test_the_cases_that_break_are_those_of_the_check_and_a_tuning_begins_with_them():
    bold = PI.of(ASKED.wrist, 9.0, 27.0)
    cases = broken_cases(ASKED, bold, 400, 1000, (3, 4))
    fresh, hunted = check(ASKED, bold, 400, 3), worst_of(ASKED, bold, 900, 4)
    names = {
        ASKED.space.case(f.places[:, i])[0].name for f in (fresh, hunted) for i in range(f.places.shape[1])
    }
    assert 8 < len(cases) <= 16
    assert {c.name for c in cases} <= names
    tuned = tune_robustly(ASKED, rounds=1, starts=0, cases=cases)
    assert tuned.rounds[0].tuning.problem.adverse == cases
