"""Captions of a comparison's figures, each beginning with what the figure shows."""

from math import isfinite

import numpy as np

from design.comparison.compare import FORWARD, TUNED, Comparison
from design.comparison.on_tasks import DRAWN
from design.comparison.tolerated import DURATION
from design.studies.study import Study
from design.synthesis.judged import nearest_limit
from design.synthesis.tuning import Tuning
from plants.measured.fitting.fit import Fit
from plants.measured.fitting.free_run import rmse
from reports.comparison.figures import coloured, step_columns
from reports.comparison.words import seconds
from reports.shared.figures.dead_time_figure import SETTLED, kept_up_to
from reports.shared.figures.fit import shown_run
from reports.shared.names import CHANNELS, limit_in_text, name_of, title_of
from reports.shared.tables import number

WORST_CAPTION = (
    "Worst settling time and overshoot over the tasks of a motion; dashed: limit on overshoot; grey bar: the "
    "paper's PI over the range of its gains; arrow: not settled within the run."
)
DEAD_TIME_CAPTION = (
    "Worst overshoot of every controller against added dead time, plant as fitted: steps of both signs from "
    f"every initial state; for an MPC from rest only, for {DURATION:g} s. In colour: the recommended PI, and "
    f"the feedback that settles first within the limits. {SETTLED}"
)
LOOPS_CAPTION = (
    "The step from rest under the recommended PI in the plane of pressure and angle: beyond the dead zone "
    "the angle follows line 1. Dots: time after the step."
)


def worst_caption(comparison: Comparison) -> str:
    """Which feedback settles first within the limits, beside the recommended PI, and what the bars are."""
    said = []
    for motion in dict.fromkeys(s.motion for s in comparison.standings):
        of = {s.controller: s for s in comparison.standings if s.motion == motion and s.controller != FORWARD}
        best = min((s for s in of.values() if not s.breaks), key=lambda s: s.worst_settling_s, default=None)
        if best is None or not isfinite(best.worst_settling_s):
            continue
        words = f"{motion}: {name_of(best.controller)}, {seconds(best.worst_settling_s)}"
        ours = of.get(TUNED)
        beside = f" ({name_of(TUNED)} {seconds(ours.worst_settling_s)})" if ours and ours is not best else ""
        said.append(words + beside)
    first = f"Fastest feedback within the limits: {'; '.join(said)}. " if said else ""
    return first + WORST_CAPTION


def loops_caption(comparison: Comparison) -> str:
    """How long the pressure crosses the dead zone before the loop's angle moves."""
    said = []
    for motion in dict.fromkeys(m for m, name in comparison.steps if name == TUNED):
        t = comparison.steps[motion, TUNED]
        moved = np.abs(t.static_angle[:, 0] - t.static_angle[0, 0]) > 0.0
        if moved.any():
            i = int(np.argmax(moved))
            width = abs(float(t.pressure[i, 0] - t.pressure[0, 0]))
            said.append(f"{motion}: {number(width, 2)} kPa in {1000.0 * float(t.time[i]):.0f} ms")
    crossed = f"Dead zone, without motion of the loop: {'; '.join(said)}. " if said else ""
    return crossed + LOOPS_CAPTION


def late_caption(study: Study) -> str:
    """Up to which dead time the recommended PI keeps the limit on overshoot, and what the curves are."""
    limit = study.comparison.limits.overshoot_percent
    kept = {m: kept_up_to(sweep, TUNED, limit) for m, sweep in (study.late or {}).items()}
    said = "; ".join(f"{m}: {words}" for m, words in kept.items() if words)
    return f"{said[0].upper()}{said[1:]}. {DEAD_TIME_CAPTION}" if said else DEAD_TIME_CAPTION


def fit_caption(motion: str, fit: Fit) -> str:
    """The error before the fit and after, and what is drawn."""
    run, channel = shown_run(fit), "angle_deg" if fit.campaign.stage == "wrist" else "pressure_kPa"
    before, after = (rmse([run], channel, b, run.role) for b in (True, False))
    unit = CHANNELS[channel][1]
    said = f"RMSE {number(before)} {unit} before the fit, {number(after)} {unit} after. " if after else ""
    return (
        f"{title_of(motion)}, {run.recording.name}: {said}Measured and simulated from the command alone; "
        "residuals; angle over pressure."
    )


def map_caption(motion: str, tuning: Tuning) -> str:
    """How to read the map of the gains, and which limit the tuned ones are nearest to."""
    nearest = nearest_limit(tuning.at, 0)
    near = "" if nearest is None else f", nearest to the limit on {limit_in_text(nearest)}"
    return (
        f"{title_of(motion)}: worst cost over the gains, dark is worse. Star: the tuned gains{near}. Inside "
        "the black line: every limit met; hatching: the limit broken most."
    )


def steps_caption(comparison: Comparison, motion: str) -> str:
    """When the controllers in colour settle, and what is drawn."""
    named = [name for m, name in comparison.steps if m == motion]
    return (
        f"{title_of(motion)}, step of {comparison.rig.task.step:g} deg from rest: "
        f"{_settled(comparison, motion)}{len(named)} controllers, plant as fitted. In colour: the "
        f"{name_of(TUNED)}, and in each column the other that settles first within the limits."
    )


def _settled(comparison: Comparison, motion: str) -> str:
    """When the controllers in colour settle after the step from rest."""
    columns = step_columns(comparison, motion).values()
    shown = dict.fromkeys(n for names in columns for n in coloured(comparison, motion, names))
    times = {
        r.controller: r.metrics["settling_time_s"]
        for r in comparison.rows
        if r.motion == motion and r.task_id == DRAWN
    }
    settled = [n for n in shown if n in times]
    verbs = ["settles in", *["in"] * len(settled)]  # said once
    said = [f"{name_of(n)} {verb} {seconds(times[n])}" for n, verb in zip(settled, verbs, strict=False)]
    return f"{', '.join(said)}. " if said else ""
