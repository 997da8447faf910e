"""One small comparison, and the fit of a small synthetic campaign, for all tests of the reports."""

from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from design.alternatives.designs import LQI_NAME, MAKERS, design_others
from design.alternatives.lqi_design import design_lqi
from design.comparison.behind_dead_time import behind_dead_time
from design.comparison.break_even import BreakEven, break_even
from design.comparison.compare import compare
from design.contest import Contest, contest
from design.controllers.feedforward import Feedforward
from design.controllers.pi import PI
from design.evaluation.scenarios import Spread, tuning_scenarios
from design.mpc.fallback import HELD, SOLVED, Info
from design.mpc.timing import Ledger, ledger
from design.robustness.assess import Assessment, assess
from design.robustness.box import box_of
from design.robustness.certificates.continuous.search import RUNGS
from design.robustness.gain_plane import gain_plane
from design.robustness.requirement import requirement
from design.studies.decision import Decision, decide
from design.studies.paper import redrawn
from design.studies.robustness_study import RobustnessStudy, study_of
from design.studies.shown.cell_steps import map_steps
from design.studies.study import Question, Study
from design.synthesis.answer import answer
from design.synthesis.requirements import Problem
from design.synthesis.tuning import Region, tune
from design.synthesis.tuning_rules import baselines
from plants import Wrist, built_in
from plants.measured.campaigns.campaign import Campaign, load_campaign
from plants.measured.campaigns.recording import Recording
from plants.measured.fitting.fit import Fit
from plants.measured.fitting.free_run import FreeRun
from plants.measured.trace.result import Trace
from plants.measured.trace.trace import trace_campaign
from tests.rig.campaign import make_campaign

QUICK = {**MAKERS, LQI_NAME: partial(design_lqi, generations=3)}
"""The other designs, of which one takes its time."""


def small_fit(motion: str) -> Fit:
    """A stand-in for a fit of one motion: the model's own response with noise, judged on itself."""
    before, wrist = built_in(motion), Wrist.from_values(built_in(motion).values)
    names = ["a1", "w1", "Tw"]
    fitted = before.fitted(
        {n: before.values[n] * 1.05 for n in names}, {"a1": 0.002, "w1": None, "Tw": 0.01}, "rig"
    )
    v = 2.0 + 1.5 * np.sin(np.arange(6000) / 1500.0)
    r = wrist.simulate(v, every=10)
    noise = 0.05 * np.sin(np.arange(r.time.size) * 7.0)
    recording = Recording("sine.csv", r.time, np.append(v[::10], v[-1]), r.angle + noise, r.pressure + noise)
    runs = tuple(
        FreeRun(recording, role, r.pressure, r.angle, r.pressure, r.angle * 1.1)
        for role in ("fit", "validate")
    )
    errors = {"angle_deg": 0.3, "pressure_kPa": 0.06}
    one = (recording,)
    return Fit(
        Campaign(f"{motion} rig", motion, "wrist", "rest", 0.01, one, one, "0123456789abcdef" * 4),
        before, fitted, {"angle_deg": 0.05, "pressure_kPa": 0.05}, errors, errors,
        {k: 2 * v for k, v in errors.items()}, runs, stages={}, at_bounds=(),
    )  # fmt: skip


@cache
def small_contest() -> Contest:
    """The tuned PI and a timid one on a dozen plants."""
    sets = {m: built_in(m) for m in ("flexion", "deviation")}
    given = {"tuned": PI(3.0, 10.0), "paper": PI(1.2, 2.2)}
    return contest(sets, dict.fromkeys(sets, given), count=12)


@cache
def small_break_even() -> dict[str, BreakEven]:
    """Feedforward alone on few errors of two kinds, short steps."""
    wrist = Wrist.flexion()
    grids = {"loop width": np.array([-0.3, 0.0, 0.3]), "dead time": np.array([0.0, 0.04])}
    others = {"feedforward": Feedforward.of(wrist)}
    return {"flexion": break_even(wrist, PI(3.0, 10.0), others, grids, duration=4.0)}


def small_ledgers() -> dict[str, dict[str, Ledger]]:
    """Made up, so that its numbers are known: a PI that misses 5 of 1000 steps and a punctual MPC."""
    late = [Info(SOLVED, "", 0, 0, 0, 2_000_000 if k < 5 else 10_000) for k in range(1000)]
    punctual = [Info(HELD if k == 3 else SOLVED, "", 4, 20_000, 50_000, 30_000) for k in range(100)]
    return {"flexion": {"tuned": ledger(late, 1e-3), "linear MPC": ledger(punctual, 20e-3)}}


@cache
def small_trace() -> Trace:
    """The trace of a short campaign of a rig whose branches are curved."""
    with TemporaryDirectory() as place:
        folder = Path(place) / "bent"
        curved = "branch-curvature"
        make_campaign(folder, "flexion", [curved], seed=21, short=True, variants={curved: 1})
        return trace_campaign(load_campaign(folder), built_in("flexion"))


@cache
def small_assessment() -> Assessment:
    """What can be said of a PI from few samples and a short search."""
    box = box_of(built_in("flexion"), Spread())
    return assess(box, PI(2.3, 6.4), samples=60, budget=400)


@cache
def small_robustness() -> RobustnessStudy:
    """The same with a coarse plane of the gains, on few scenarios."""
    assessment = small_assessment()
    wrist = assessment.wrist
    problem = Problem.of(wrist, tuning_scenarios(wrist)[:6], duration=4.0)
    return study_of(assessment, gain_plane(problem, tuple(RUNGS), points=5))


@cache
def small_study() -> Study:
    """Both motions compared with given gains; one of them tuned on a coarse map, and fitted."""
    sets = {m: built_in(m) for m in ("flexion", "deviation")}
    wrists = {m: Wrist.from_values(s.values) for m, s in sets.items()}
    problems = {m: Problem.of(w, tuning_scenarios(w)[:10], duration=6.0) for m, w in wrists.items()}
    tuned = {"flexion": PI(3.0, 10.0), "deviation": PI(6.5, 19.0)}
    designs = {m: design_others(p, makers=QUICK) for m, p in problems.items()}
    comparison = compare(wrists, tuned, designs=designs)
    problem = problems["flexion"]
    tunings = {"flexion": tune(problem, Region(points=8), starts=2)}
    question = Question(sets, {"flexion": small_fit("flexion")})
    late = {m: behind_dead_time(w, {"tuned": tuned[m], **baselines(w)}) for m, w in wrists.items()}
    return Study(
        question, {m: answer(t) for m, t in tunings.items()}, comparison, redrawn=redrawn(wrists), late=late,
        cells={m: map_steps(t) for m, t in tunings.items()},
    )  # fmt: skip


@cache
def small_decision() -> Decision:
    """What is recommended of two PIs that were judged on few cases, nothing proved."""
    stated = requirement(built_in("flexion"))
    candidates = {"tuned": PI(3.0, 10.0), "robust PI": PI(2.0, 5.0)}
    return decide("flexion", stated, candidates, samples=60, runs=300, prove=False)


def whole_study() -> Study:
    """The same with all that a study may have."""
    return replace(
        small_study(), contest=small_contest(), break_even=small_break_even(),
        execution_times=small_ledgers(), decisions={"flexion": small_decision()},
    )  # fmt: skip
