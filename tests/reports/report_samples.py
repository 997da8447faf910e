"""One small comparison, and the fit of a small synthetic campaign, for all tests of the reports."""

from dataclasses import dataclass
from functools import cache

import numpy as np

from design.alternatives.designs import design_others
from design.compare import Comparison, compare
from design.contest import Contest, contest
from design.controllers.pi import PI
from design.requirements import Problem
from design.tasks import tuning_scenarios
from design.tuning import Region, Tuning, tune
from plants import ParameterSet, Wrist, built_in
from plants.measured.campaign import Campaign
from plants.measured.fit import Fit, Run
from plants.measured.recording import Recording


@dataclass(frozen=True)
class Compared:
    """What a page is made of."""

    comparison: Comparison
    tunings: dict[str, Tuning]
    sets: dict[str, ParameterSet]
    wrists: dict[str, Wrist]
    fits: dict[str, Fit]


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
        Run(recording, role, r.pressure, r.angle, r.pressure, r.angle * 1.1) for role in ("fit", "validate")
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
def compare_both() -> Compared:
    """Both motions compared with given gains; one of them tuned on a coarse map, and fitted."""
    sets = {m: built_in(m) for m in ("flexion", "deviation")}
    wrists = {m: Wrist.from_values(s.values) for m, s in sets.items()}
    problems = {m: Problem.of(w, tuning_scenarios(w)[:10], duration=6.0) for m, w in wrists.items()}
    tuned = {"flexion": PI(3.0, 10.0), "deviation": PI(6.5, 19.0)}
    designs = {m: design_others(p) for m, p in problems.items()}
    comparison = compare(wrists, tuned, designs=designs)
    problem = problems["flexion"]
    tunings = {"flexion": tune(problem, Region(points=8), starts=2)}
    return Compared(comparison, tunings, sets, wrists, {"flexion": small_fit("flexion")})
