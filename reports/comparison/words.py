"""What a comparison page says in sentences: summary, verdict on the fit, evidence, captions."""

from collections.abc import Mapping, Sequence
from math import isfinite

from design.alternatives.convex_concave import NOISE_GAIN
from design.alternatives.lqi_design import WASHOUT
from design.comparison.compare import PAPER, TUNED, Comparison, Row
from design.contest.plants import RIGS
from design.contest.scores import BESIDE, Contest, Score
from design.contest.statistics import FEWEST, LEVEL
from design.evaluation.scenarios import HEADROOM
from design.studies.study import Study
from design.synthesis.answer import Answer
from design.synthesis.tuning import ACTIVE
from design.synthesis.tuning_rules import PAPER_FACTOR, PAPER_GAINS
from plants.measured.fit import EXPLAINED, Fit
from plants.parameters.quantities import Assumed, Fitted, ParameterSet
from reports.comparison.contest import MAIN as PERTURBED
from reports.comparison.figures import PIS, SOON
from reports.shared.fit import shown_run
from reports.shared.names import COST_WORDS, WINDOW, limit_name, name_of, title_of
from reports.shared.tables import fixed, listed, number, spaced
from reports.shared.tuning import refused

FURTHER = (
    "The law by which the regulator's P gain varies: dP/dt = k(e) e with "
    "k(e) = k_slow + (k_fast − k_slow) e² / (e² + e0²).",
    "The form of a PI: command = (rest pressure + Kp e + Ki ∫e dt) / gain, on kilopascals, the "
    "integrator stopped while the command is clipped, unless the error drives it back.",
    f"The paper's gains: Kp = {PAPER_GAINS[0]:g} kPa/deg, Ki = {PAPER_GAINS[1]:g} kPa/(deg s) stand in for "
    f"the lost ones, with a factor of {PAPER_FACTOR:g} either way, because a PI with them is as slow as the "
    "paper reads.",
    "How far the corners of the plant lie that gains are tuned on: loop width ±20 %, slopes ±10 %, Tw ±20 % "
    "unless set otherwise.",
    f"How much noise the other designs may pass on: at most {NOISE_GAIN:g} V of command per degree of noise "
    "of the angle, at any frequency; the peak of the complementary sensitivity is limited like that of the "
    "sensitivity.",
    "The robust LQI measures the pressure and observes the static angle from it: moved by the measured "
    "pressure times the mean slope of the lines, corrected by the measured angle. On a branch of another "
    "slope that is wrong in proportion to the speed of the pressure, so that feedback and observer cannot be "
    "designed apart; the loop with the observer is what is simulated, and its poles and margins are taken on "
    f"every branch. What the regulator's gain is off by it unlearns at {WASHOUT:g} rad/s.",
    "One pressure stands for a motion, its antagonist mirrored about the rest pressure.",
    "In the contest on other plants: the noise and the quantum of the sensor, the coupling of the motions, "
    "and the size of the load and of each effect that no model has.",
)
"""What is assumed besides the values of parameters."""

APART = "The two motions do not act on each other, except where both are played at once on other plants."
"""The same of a rig with two motions."""

WORST_CAPTION = (
    "Worst settling time and overshoot over the tasks of a motion. See who is quick, to the left above, and "
    "still left of the dashed limit of the overshoot. The grey bar is the range that the paper's PI takes "
    "over the range of its gains; an arrow means that it does not settle while it is watched."
)
LOOPS_CAPTION = (
    "The step from rest under the tuned PI in the plane of pressure and angle. See how the angle stays "
    "while the pressure crosses the dead zone, until line 1 is met, and then rises beside it. The dots are "
    "instants after the step."
)


def further(motions: Sequence[str]) -> list[str]:
    """What is assumed besides the values of parameters, of a rig with these motions."""
    return [*FURTHER, *([APART] if len(motions) > 1 else [])]


def summary(study: Study) -> list[str]:
    """Three sentences: what the tuned PI does, what would be better, and what both rest on."""
    comparison, contest = study.comparison, study.contest
    better = _on_others(comparison, contest) if contest else _as_it_is(comparison)
    return [_ours(study), better, _rests_on(study.plants, study.fits)]


def _ours(study: Study) -> str:
    """How fast the tuned PI is on each motion, and how it stands to the paper's."""
    said, comparison = [], study.comparison
    for s in comparison.standings:
        if s.controller == TUNED:
            broken = listed([limit_name(n).lower() if n != "Ms" else n for n in s.breaks])
            held = f"though it breaks the limit on {broken}" if s.breaks else "holding every limit"
            if s.motion in study.refusals:
                held += ", and no gains hold every limit on all plants tuned for"
            paper = _paper([r for r in comparison.rows if (r.motion, r.controller) == (s.motion, PAPER)])
            time = f"{'in ' if isfinite(s.worst_settling_s) else 'not within '}{_seconds(s.worst_settling_s)}"
            said.append(f"on {s.motion} {time}{paper}, {held}")
    return (
        f"The tuned PI settles the worst of the {comparison.rig.task.step:g} degree tasks {'; '.join(said)}."
    )


def _paper(rows: list[Row]) -> str:
    """In brackets, how long the paper's PI takes over the range of its gains; empty where there is none."""
    if not rows:
        return ""
    low, high = (max(getattr(r, side)["settling_time_s"] for r in rows) for side in ("low", "high"))
    return f" (the paper's stand-in {_span(low, high)})"


def _span(low: float, high: float) -> str:
    if low == high:
        return f"{_seconds(low)}" if isfinite(low) else f"not within {_seconds(low)}"
    return f"{low:.2f} s to {f'{high:.2f} s' if isfinite(high) else f'more than {WINDOW:g} s'}"


def _seconds(value: float) -> str:
    return f"{value:.2f} s" if isfinite(value) else f"{WINDOW:g} s"


def _as_it_is(comparison: Comparison) -> str:
    """Which others are faster on the plants as they are."""
    said = []
    for ours in (s for s in comparison.standings if s.controller == TUNED):
        others = [s for s in comparison.standings if s.motion == ours.motion and s.controller != TUNED]
        held = [s for s in others if not s.breaks and s.worst_settling_s < ours.worst_settling_s]
        if held:
            best = min(held, key=lambda s: s.worst_settling_s)
            said.append(
                f"on {ours.motion} {len(held)} of {len(others)} others are faster under every limit, "
                f"{name_of(best.controller)} with {_seconds(best.worst_settling_s)} first"
            )
        else:
            said.append(f"on {ours.motion} none of {len(others)} others is faster under every limit")
    lasts = "whether that lasts on other plants was not tried"
    return f"Where the plant is as believed, {'; '.join(said)}; {lasts}."


def _on_others(comparison: Comparison, contest: Contest) -> str:
    """Who has the least error on the perturbed plants of those that keep the overshoot."""
    limit = comparison.limits.overshoot_percent
    said, lost = [], []
    for motion in dict.fromkeys(s.motion for s in comparison.standings):
        scores = _played(contest, motion)
        kept = [s for s in scores if limit is None or s.mean["overshoot_percent"] <= limit]
        best = min(kept, key=lambda s: s.mean["iae_deg_s"], default=None)
        if not scores:
            said.append(f"none on {motion}, which was not tried")
        elif best is None:
            said.append(f"none on {motion}")
        else:
            said.append(_least(best, contest.reference, motion))
            lost += [name_of(best.controller)] if _loses_itself(contest, best) else []
    among = "" if limit is None else f", of those that keep the overshoot within {limit:g} % on average,"
    where = "On perturbed plants with a noisy sensor, but without effects that the models lack"
    return f"{where}{among or ','} the least IAE has {'; and '.join(said)}{_but(lost)}."


LATE = next(name for name in RIGS if name.startswith("dead time"))
"""The rig that is late, as real ones are."""


def _loses_itself(contest: Contest, best: Score) -> bool:
    """Whether a controller fails to settle on most plants of the rig that is late."""
    scores = contest.of(best.motion, f"{LATE}{BESIDE}", best.family)
    scores = scores or contest.of(best.motion, LATE, best.family)
    return any(s.mean["unsettled"] > 0.5 for s in scores if s.controller == best.controller)


def _but(lost: list[str]) -> str:
    if not lost:
        return ""
    names, late = list(dict.fromkeys(lost)), LATE.replace("dead time", "a dead time of")
    settles = "settles" if len(names) == 1 else "settle"
    return f"; but with {late} that no model knows, {listed(names)} never {settles}"


def _played(contest: Contest, motion: str) -> list[Score]:
    """The scores of the steps on perturbed plants, with the MPCs where these met enough of them."""
    field, family = PERTURBED
    beside = contest.of(motion, f"{field}{BESIDE}", family)
    return beside if beside and beside[0].plants >= FEWEST else contest.of(motion, field, family)


def _least(best: Score, reference: str, motion: str) -> str:
    i, here = best.against["iae_deg_s"], f"on {motion}, over {best.plants} plants,"
    if best.controller == reference:
        return f"{here} the {name_of(reference)} itself, {number(best.mean['iae_deg_s'])} deg s"
    level = f"{100 * LEVEL:g} % interval"
    interval = f" ({level} {fixed(i.low, 2)} to {fixed(i.high, 2)})" if isfinite(i.low) else ""
    return f"{here} {name_of(best.controller)}, {fixed(i.mean, 2)} deg s{interval} against the tuned PI"


def _rests_on(sets: Mapping[str, ParameterSet], fits: Mapping[str, Fit]) -> str:
    """What was measured, fitted and assumed."""
    origins = [p.provenance for s in sets.values() for p in s.parameters.values()]
    assumed = sum(isinstance(o, Assumed) for o in origins)
    rest = "All of this is simulated, on plants whose parameters are stated or fitted"
    if assumed:
        still = "still " if any(isinstance(o, Fitted) for o in origins) else ""
        rest = (
            f"All of this is simulated; {assumed} of the plants' {len(origins)} parameters are {still}assumed"
        )
    lacking = [m for m, f in fits.items() if any(r > EXPLAINED for r in f.ratios.values())]
    if lacking:
        rest += (
            f", and the fitted model of {listed(lacking)} does not explain its recordings down to the noise"
        )
    return f"{rest}."


def misfit(fit: Fit) -> str:
    """Whether the fitted model explains the held-out recordings down to the noise."""
    if fit.remarks:
        return " ".join(fit.remarks)
    return "The errors are no more than the noise: the model explains these recordings."


def fit_words(fit: Fit) -> str:
    """Which recordings were fitted to and which judged."""
    took = [r.recording.name for r in fit.runs if r.role == "fit"]
    apart = [r.recording.name for r in fit.runs if r.role == "validate"]
    judged = f"judged on {', '.join(apart)}, which were held out" if apart else "no recording was kept apart"
    return f"Fitted to {', '.join(took)} of the campaign “{fit.campaign.name}”; {judged}."


def fit_caption(motion: str, fit: Fit) -> str:
    """What the figure of a fit shows."""
    return (
        f"{title_of(motion)}: measured and simulated on {shown_run(fit).recording.name}, with the "
        "parameters before the fit and after it; the errors of both; and the angle against the pressure. "
        "See whether the error after the fit is noise or still moves with the signal. The simulation sees "
        "the command alone."
    )


def found(answer: Answer) -> str:
    """Cost at the tuned gains, where it is taken, and what keeps it from being lower."""
    t = answer.tuning
    unit = COST_WORDS.get(t.problem.cost, "").partition("[")[2].rstrip("]")
    where = t.problem.place("cost", int(t.at.cost_at[0]))
    words = f"Worst cost {number(float(t.at.cost[0]))} {unit}, on {spaced(where)}."
    if t.problem.adverse:
        words += (
            " Every limit holds for all that the rig states that it may do, dead time included: beside "
            f"{len(t.problem.scenarios)} steps the gains are tuned on {len(t.problem.adverse)} cases that a "
            "search for the worst found."
        )
    if answer.refusal is not None:
        return f"{words} The answer is {refused(answer.refusal)}."
    if t.active:
        active = [limit_name(n) for n, excess in t.at.excess.items() if excess[0] > -ACTIVE]
        return f"{words} Active, so that less cost would break a limit: {' and '.join(active)}."
    return f"{words} No limit is active: the optimum lies inside all of them."


def evidence(answer: Answer) -> str:
    """Why the gains are taken for the global optimum."""
    t = answer.tuning
    region, ratio = t.region, t.region.resolution
    ends = [s.cost for s in t.searches if s.feasible]
    near = sum(c <= 1.01 * float(t.at.cost[0]) for c in ends)
    held = "none held the limits"
    head = "What was searched" if answer.refusal else "Evidence that this is the global optimum"
    if ends:
        held = f"{len(ends)} ended where every limit is held, {near} of them within 1 % of the cost above"
    words = (
        f"{head}: a map of {region.points} × {region.points} gains covers "
        f"Kp from {region.Kp[0]:g} to {region.Kp[1]:g} kPa/deg and Ki from {region.Ki[0]:g} to "
        f"{region.Ki[1]:g} kPa/(deg s), neighbours {100 * (ratio[0] - 1):.0f} % and "
        f"{100 * (ratio[1] - 1):.0f} % apart. Of {len(t.searches)} local searches from its valleys "
        f"and other cells, {held}. "
        "Three ever finer maps around the best point end at the gains given."
    )
    if t.problem.set_aside:
        words += (
            f" {len(t.problem.set_aside)} of {len(t.problem.scenarios) + len(t.problem.set_aside)} scenarios "
            f"were set aside, such as {spaced(t.problem.set_aside[0].name)}: the command that holds them "
            f"lies within {HEADROOM:g} V of the end of the range, or beyond it."
        )
    edge = " The optimum lies on the edge of the searched region: a wider one may hold a better one."
    return words + (edge if t.on_edge else "")


def map_caption(motion: str) -> str:
    """How to read the map of the gains."""
    return (
        f"{title_of(motion)}: worst cost over the gains, dark is worse. See where the star lies: at the "
        "lightest place inside the black line, within which every limit is held; elsewhere the hatching "
        "tells which one is broken most."
    )


def steps_caption(comparison: Comparison, motion: str) -> str:
    """How to read the responses."""
    named = [name for m, name in comparison.steps if m == motion]
    count = len(named)
    scales = "" if set(named) <= set(PIS) else " The right column shows less of the time, larger."
    return (
        f"{title_of(motion)}: a step of {comparison.rig.task.step:g} deg from rest under {count} "
        "controllers, the "
        f"{name_of(TUNED)} in every panel. See who is there first without overshoot, what command that "
        f"takes, and, in the last row, who is still on the way after {SOON:g} s.{scales}"
    )
