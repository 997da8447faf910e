"""A study of controllers: what was asked of which plants, and all that came of it.

The tuned PI is the one that is recommended, for all that the rig states that it may do, dead time included;
beside it stands the one that is tuned for the steps alone, and other designs, which are made under the limits
and on the scenarios of that one.

Whoever shows one (the command, a page, a notebook) takes the value and computes nothing.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from design.alternatives.designs import (
    FORWARD_PI,
    MAKERS,
    Design,
    RequirementDesign,
    design_mpcs,
    design_others,
)
from design.comparison.behind_dead_time import DeadTimeSweep, behind_dead_time
from design.comparison.break_even import BreakEven, break_even
from design.comparison.compare import FORWARD, TUNED, Comparison, compare, controllers
from design.comparison.execution_time import deadlines
from design.comparison.rows import WITHOUT_DEAD_TIME
from design.contest import Contest, contest
from design.controllers.controller import Controller
from design.controllers.pi import PI
from design.mpc.timing import Ledger
from design.robustness.requirement import requirement
from design.robustness.tuning.gain_search import with_evidence
from design.robustness.tuning.given_gains import given_gains
from design.robustness.tuning.recommended import tune_candidates
from design.studies.decision import Decision, decide
from design.studies.paper import redrawn
from design.studies.shown.cell_steps import CellSteps, map_steps
from design.studies.shown.panels import Panel
from design.studies.stages import NOTHING_KEPT, Stages
from design.studies.verdict import Verdict, verdicts
from design.synthesis.answer import Answer, OutOfReach, Refusal, answer
from design.synthesis.designed_plant import designed
from design.synthesis.requirements import Problem, default_problem
from design.synthesis.tuning import Region, Tuning, tune
from plants.errors import InputError
from plants.measured.fitting.fit import Fit
from plants.parameters.quantities import ParameterSet
from plants.wrist import Wrist

Tell = Callable[[str, float], None]
STARTS = 2
"""Local searches that show whether other valleys are as low as that of the recommended gains."""


@dataclass(frozen=True)
class Question:
    """A comparison to make: the best PI for each plant, and how it compares with other designs.

    plants: a parameter set for each motion, in the order in which they are shown; fits: those that sets
    came from, of motions that were measured; points: of the map in each gain; samples: perturbed plants of
    each motion, 0 for none; mpc_plants: of these, plants that the MPCs meet too; plain: tune for the steps
    alone; more: further controllers
    by motion and name; others: designs beside the PI that are there already, by motion and name;
    jobs: threads, all processors where None; stages: of the design that the gains are of,
    whose proofs need not be found again.
    """

    plants: Mapping[str, ParameterSet]
    fits: Mapping[str, Fit] = field(default_factory=dict)
    points: int = 40
    samples: int = 50
    mpc_plants: int = 10
    plain: bool = False
    given: Mapping[str, PI] = field(default_factory=dict)
    more: Mapping[str, Mapping[str, Controller]] = field(default_factory=dict)
    seed: int = 0
    jobs: int | None = None
    stages: Stages = NOTHING_KEPT
    others: Mapping[str, Mapping[str, RequirementDesign]] = field(default_factory=dict)

    @cached_property
    def wrists(self) -> dict[str, Wrist]:
        """The wrist of each motion."""
        return {motion: Wrist.of(plant) for motion, plant in self.plants.items()}


@dataclass(frozen=True)
class Study:
    """Result of a question.

    answers: of the tuning of each motion; comparison: of every controller; contest: on perturbed plants,
    None where none were asked for or can be drawn; break_even: how wrong the model of a feedforward may
    be, by motion, of those that have one; execution_times: of the steps of each controller, by motion and
    name; redrawn: what the paper's figures show of these plants, by number, where they are the paper's two
    motions; without_mpc: why MPCs were left out, empty where they were not; decisions: what is
    recommended of each motion, judged by the rig's whole requirement; late: overshoot of every controller
    behind a growing dead time, by motion; cells: steps under every cell of the map of each tuning.
    """

    question: Question
    answers: Mapping[str, Answer]
    comparison: Comparison
    contest: Contest | None = None
    break_even: Mapping[str, BreakEven] | None = None
    execution_times: Mapping[str, Mapping[str, Ledger]] | None = None
    redrawn: Mapping[int, tuple[Panel, ...]] = field(default_factory=dict)
    without_mpc: str = ""
    decisions: Mapping[str, Decision] = field(default_factory=dict)
    late: Mapping[str, DeadTimeSweep] = field(default_factory=dict)
    cells: Mapping[str, CellSteps] = field(default_factory=dict)

    @property
    def tunings(self) -> dict[str, Tuning]:
        """The tuning of each motion."""
        return {motion: a.tuning for motion, a in self.answers.items()}

    @property
    def plants(self) -> Mapping[str, ParameterSet]:
        """The parameter set of each motion."""
        return self.question.plants

    @property
    def fits(self) -> Mapping[str, Fit]:
        """The fits of motions that were measured."""
        return self.question.fits

    @property
    def motions(self) -> list[str]:
        """Motions that were compared, in the order in which they are shown."""
        return list(dict.fromkeys(s.motion for s in self.comparison.standings))

    @property
    def refusals(self) -> dict[str, Refusal]:
        """Why no gains meet every limit, of the motions of which none do."""
        return {m: a.refusal for m, a in self.answers.items() if a.refusal is not None}

    @property
    def verdicts(self) -> dict[str, Verdict]:
        """What the comparison concludes of each motion."""
        return verdicts(self.comparison, self.refusals)

    @property
    def unperturbed(self) -> list[str]:
        """Motions that perturbed plants were asked for and cannot be drawn: their wrist has effects."""
        return [m for m, plant in self.plants.items() if plant.effects and self.question.samples]


def study(question: Question, progress: Tell | None = None) -> Study:
    """Tune, design, compare and perturb; `progress` is told what is going on, and the share that is done.

    Raises InputError as `design.contest.contest` does.
    """
    tell = progress or (lambda stage, share: None)
    wrists, jobs = question.wrists, question.jobs
    simple = {
        m: tune(
            default_problem(w, jobs=jobs), Region.of(w, question.points), seed=question.seed,
            progress=_part(tell, f"tune {m} without dead time"),
        )
        for m, w in wrists.items()
    }  # fmt: skip
    tunings = simple if question.plain else _recommended(question, tell)
    more: dict[str, dict[str, Controller]] = {m: dict(question.more.get(m, {})) for m in wrists}
    if not question.plain:
        more = {m: {WITHOUT_DEAD_TIME: simple[m].controller, **of} for m, of in more.items()}
    tuned = {m: t.controller for m, t in tunings.items()}
    tell("MPCs", 0.0)
    mpcs, without_mpc = _mpcs(wrists)
    designs = {m: _others(question, m, t.problem, tell) for m, t in simple.items()}
    comparison = compare(
        wrists, tuned, designs=designs, more=more, periodic=mpcs,
        progress=_part(tell, "compare"),
    )  # fmt: skip
    alone = _alone(wrists, tuned, designs, more)
    maps = _break_evens(wrists, alone, jobs, tell)
    late = {}
    for m, w in wrists.items():
        tell(f"{m}, dead time", 0.0)
        late[m] = behind_dead_time(w, alone[m] | mpcs.get(m, {}))
    tell("times of steps", 0.0)
    times = {m: deadlines(w, alone[m], mpcs.get(m)) for m, w in wrists.items()}
    broad = _contest(question, alone, mpcs, _part(tell, "other plants"))
    answers = {m: answer(t) for m, t in tunings.items()}
    decisions = {
        m: _decided(question, m, alone[m], _part(tell, f"{m}, decision"))
        for m, a in answers.items()
        if not isinstance(a.refusal, OutOfReach)
    }
    cells = {m: map_steps(t) for m, t in tunings.items()}
    return Study(
        question, answers, comparison, broad, maps, times, redrawn(wrists), without_mpc, decisions, late,
        cells,
    )  # fmt: skip


def _others(question: Question, motion: str, problem: Problem, tell: Tell) -> dict[str, Design | str]:
    """The other designs of a motion, in their order: those that are given, the rest made on a problem; then
    those given that are not made here, such as a cascade."""
    given = question.others.get(motion, {})
    left = {n: make for n, make in MAKERS.items() if n not in given}
    made = design_others(problem, _part(tell, f"{motion}, other designs"), left)
    return {n: given.get(n) or made[n] for n in MAKERS} | {n: d for n, d in given.items() if n not in MAKERS}


def _part(tell: Tell, what: str) -> Tell:
    """Progress of a part of the study."""
    tell(what, 0.0)
    return lambda stage, share: tell(f"{what}, {stage}", share)


def _mpcs(wrists: Mapping[str, Wrist]) -> tuple[dict[str, dict[str, Any]], str]:
    """The MPCs of each motion; none, and why, where their solver is not installed."""
    try:
        return {motion: design_mpcs(wrist) for motion, wrist in wrists.items()}, ""
    except InputError as error:
        return {}, str(error)


def _recommended(question: Question, tell: Tell) -> dict[str, Tuning]:
    """The recommended tuning of each motion, found or given, with the map of its gains."""
    found: dict[str, Tuning] = {}
    for m, plant in question.plants.items():
        asked = requirement(designed(plant))
        region = Region.of(asked.wrist, question.points)
        if m in question.given:
            tell(f"{m}, map", 0.0)
            found[m] = given_gains(asked, question.given[m], region, question.jobs)
            continue
        both = tune_candidates(
            asked, region, question.seed, jobs=question.jobs, progress=_part(tell, f"tune {m}")
        )
        best = both.best
        tell(f"tune {m}, map", 0.9)
        found[m] = best.final if best.ended == "out of reach" else with_evidence(best.final, STARTS)
    return found


def _alone(
    wrists: Mapping[str, Wrist],
    tuned: Mapping[str, Any],
    designs: Mapping[str, Mapping[str, Design | str]],
    more: Mapping[str, Mapping[str, Controller]],
) -> dict[str, dict[str, Controller]]:
    """One controller of each kind, by motion and name: of the paper's range the stand-in."""
    return {
        m: {n: alike[0] for n, alike in controllers(w, tuned[m], designs[m], more[m]).items()}
        for m, w in wrists.items()
    }


def _break_evens(
    wrists: Mapping[str, Wrist],
    alone: Mapping[str, Mapping[str, Controller]],
    jobs: int | None,
    tell: Tell,
) -> dict[str, BreakEven]:
    """The break-even map of each motion: what has a feedforward against the tuned PI, of a wrist that has an
    inverse and no effects of its own."""
    found = {}
    for motion, wrist in wrists.items():
        others = {n: c for n, c in alone[motion].items() if n in (FORWARD, FORWARD_PI)}
        if others and not wrist.effects:
            tell(f"{motion}, break-even map", 0.0)
            found[motion] = break_even(wrist, alone[motion][TUNED], others, jobs=jobs)
    return found


def _decided(question: Question, motion: str, alone: Mapping[str, Controller], tell: Tell) -> Decision:
    """What is recommended among the tuned PI and the PIs that were asked for beside it."""
    named = (TUNED, WITHOUT_DEAD_TIME, *question.more.get(motion, {}))
    candidates = {n: c for n, c in alone.items() if n in named and isinstance(c, PI)}
    plant = designed(question.plants[motion])
    return decide(
        motion, requirement(plant), candidates, question.seed, question.jobs, tell, stages=question.stages
    )


def _contest(
    question: Question,
    alone: Mapping[str, Mapping[str, Controller]],
    mpcs: Mapping[str, Mapping[str, Any]],
    tell: Tell,
) -> Contest | None:
    """On perturbed plants, of the motions whose wrist has no effects of its own."""
    bare = {m: plant for m, plant in question.plants.items() if not plant.effects}
    if not question.samples or not bare:
        return None
    return contest(
        bare, {m: alone[m] for m in bare}, count=question.samples, seed=question.seed, jobs=question.jobs,
        progress=tell, periodic=mpcs if question.mpc_plants else None, periodic_count=question.mpc_plants,
    )  # fmt: skip
