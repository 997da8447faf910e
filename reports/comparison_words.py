"""What a comparison page says in sentences: summary, verdict on the fit, evidence, captions."""

from collections.abc import Mapping

from design.alternatives.convex_concave import NOISE_GAIN
from design.alternatives.lqi_design import WASHOUT
from design.answer import refusal
from design.compare import TUNED, Comparison
from design.rules import PAPER_FACTOR, PAPER_GAINS
from design.tasks import HEADROOM, STEP
from design.tuning import ACTIVE, Tuning
from plants.measured.fit import EXPLAINED, Fit
from plants.quantities import Assumed, Fitted, ParameterSet
from reports.comparison_tables import limit_name
from reports.figures import SOON, name_of, title_of
from reports.fitted import shown_run
from reports.gain_map import COST_WORDS
from reports.tables import number

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
    "One pressure stands for a motion, its antagonist mirrored about the rest pressure; the two motions do "
    "not act on each other, except where both are played at once on other plants.",
    "In the contest on other plants: the noise and the quantum of the sensor, the coupling of the motions, "
    "and the size of the load and of each effect that no model has.",
)
"""What is assumed besides the values of parameters."""

WORST_CAPTION = (
    "Worst settling time and overshoot over the tasks of a motion. The grey bar is the range that the "
    "paper's PI takes over the range of its gains; an arrow means that it does not settle while it is "
    "watched."
)
LOOPS_CAPTION = (
    "The step from rest under the tuned PI in the plane of pressure and angle: along the dead zone until "
    "line 1 is met, then up beside it. The dots are instants after the step."
)


def summary(comparison: Comparison, sets: Mapping[str, ParameterSet], fits: Mapping[str, Fit]) -> list[str]:
    """At most three sentences: the verdicts, and what they rest on."""
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
        whose = " and ".join(lacking)
        rest += f", and the fitted model of {whose} does not explain its recordings down to the noise"
    return [*(v[:1].upper() + v[1:] for v in comparison.verdicts[:2]), f"{rest}."]


def misfit(fit: Fit) -> str:
    """Whether the fitted model explains the recordings that took no part down to the noise."""
    if fit.remarks:
        return " ".join(fit.remarks)
    return "The errors are no more than the noise: the model explains these recordings."


def fit_words(fit: Fit) -> str:
    """Which recordings were fitted to and which judged."""
    took = [r.recording.name for r in fit.runs if r.role == "fit"]
    apart = [r.recording.name for r in fit.runs if r.role == "validate"]
    judged = f"judged on {', '.join(apart)}, which took no part" if apart else "no recording was kept apart"
    return f"Fitted to {', '.join(took)} of the campaign “{fit.campaign.name}”; {judged}."


def fit_caption(motion: str, fit: Fit) -> str:
    """What the figure of a fit shows."""
    return (
        f"{title_of(motion)}: measured and simulated on {shown_run(fit).recording.name}, with the parameters "
        "before the fit and after it; the errors of both; and the angle against the pressure. The simulation "
        "sees the command alone."
    )


def found(t: Tuning) -> str:
    """Cost at the tuned gains, where it is taken, and what keeps it from being lower."""
    unit = COST_WORDS.get(t.problem.cost, "").partition("[")[2].rstrip("]")
    where = t.problem.place("cost", int(t.at.cost_at[0]))
    words = f"Worst cost {number(float(t.at.cost[0]))} {unit}, on {where}."
    no = refusal(t)
    if no:
        return f"{words} The answer is {no}."
    if t.active:
        active = [limit_name(n) for n, excess in t.at.excess.items() if excess[0] > -ACTIVE]
        return f"{words} Active, so that less cost would break a limit: {' and '.join(active)}."
    return f"{words} No limit is active: the optimum lies inside all of them."


def evidence(t: Tuning) -> str:
    """Why the gains are taken for the global optimum."""
    region, ratio = t.region, t.region.resolution
    ends = [s.cost for s in t.searches if s.feasible]
    near = sum(c <= 1.01 * float(t.at.cost[0]) for c in ends)
    held = "none held the limits"
    head = "What was searched" if refusal(t) else "Evidence that this is the global optimum"
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
            f"were set aside, such as {t.problem.set_aside[0].name}: the command that holds them lies within "
            f"{HEADROOM:g} V of the end of the range, or beyond it."
        )
    edge = " The optimum lies on the edge of the searched region: a wider one may hold a better one."
    return words + (edge if t.on_edge else "")


def map_caption(motion: str) -> str:
    """How to read the map of the gains."""
    return (
        f"{title_of(motion)}: worst cost over the gains, dark is worse. Inside the black line every limit is "
        "held; elsewhere the hatching tells which one is broken most."
    )


def steps_caption(comparison: Comparison, motion: str) -> str:
    """How to read the responses."""
    count = sum(m == motion for m, _ in comparison.steps)
    return (
        f"{title_of(motion)}: a step of {STEP:g} deg from rest under {count} controllers; angle, pressure "
        f"and command. The scale of time changes at {SOON:g} s. The {name_of(TUNED)} is drawn thick."
    )
