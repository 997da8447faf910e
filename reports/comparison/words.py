"""What a comparison page says in sentences: summary, verdict on the fit, evidence."""

from collections.abc import Sequence
from math import isfinite

from design.alternatives.convex_concave import NOISE_GAIN
from design.comparison.compare import TUNED, Comparison
from design.contest.plants import RIGS
from design.contest.scores import BESIDE, Contest, Score
from design.contest.statistics import FEWEST, LEVEL
from design.controllers.lqi import WASHOUT
from design.evaluation.scenarios import HEADROOM
from design.status import Status
from design.studies.decision import Decision
from design.studies.study import Study
from design.synthesis.answer import Answer
from design.synthesis.judged import ACTIVE, nearest_limit
from design.synthesis.tuning_rules import PAPER_FACTOR, PAPER_GAINS
from plants.measured.fitting.fit import Fit
from plants.parameters.quantities import Assumed
from reports.comparison.contest.table import MAIN as PERTURBED
from reports.shared.card import broken_words
from reports.shared.names import (
    COST_WORDS,
    WINDOW,
    limit_name,
    name_of,
    pi_name,
)
from reports.shared.tables import fixed, listed, number, spaced
from reports.shared.tuning import refused

FURTHER = (
    "The law by which the regulator's P gain varies: dP/dt = k(e) e with "
    "k(e) = k_slow + (k_fast − k_slow) e² / (e² + e0²).",
    "The form of the PI: command = (rest pressure + Kp e + Ki ∫e dt) / gain. The integrator stops while the "
    "command is clipped, unless the error drives it back.",
    f"The paper's gains: Kp = {PAPER_GAINS[0]:g} kPa/deg, Ki = {PAPER_GAINS[1]:g} kPa/(deg s) replace "
    f"the lost ones, with a range of a factor of {PAPER_FACTOR:g} either way. With them the PI is about as "
    "slow as the paper reports.",
    "The corners of the plant used in tuning: loop width ±20 %, slopes ±10 %, Tw ±20 % unless set otherwise.",
    f"The noise gain of the other designs: at most {NOISE_GAIN:g} V of command per degree of angle noise at "
    "any frequency. Mt has the same limit as Ms.",
    "The robust LQI observes the static angle from the measured pressure times the mean slope of the lines, "
    f"so feedback and observer cannot be designed separately; its washout is {WASHOUT:g} rad/s.",
    "One pressure represents each motion; the antagonist's is its mirror image about the rest pressure.",
    "In the comparison on perturbed plants: noise and resolution of the sensor, coupling of the motions, "
    "and the size of the load and of each unmodelled effect.",
)
"""What is assumed besides the values of parameters."""

APART = "The two motions are uncoupled, except in simulations of both at once on perturbed plants."
"""The same of a rig with two motions."""


def further(motions: Sequence[str]) -> list[str]:
    """What is assumed besides the values of parameters, of a rig with these motions."""
    return [*FURTHER, *([APART] if len(motions) > 1 else [])]


def title(study: Study) -> str:
    """The heading: what is recommended, or that nothing that was tried meets every limit."""
    if not study.decisions:
        return f"Holding {study.comparison.rig.task.step:g} degrees: controllers compared"
    names = list(dict.fromkeys(card_name(d) for d in study.decisions.values()))
    if all(d.holds for d in study.decisions.values()):
        return f"Recommended: {listed(names)}"
    return f"No PI tried meets every limit; the nearest: {listed(names)}"


def summary(study: Study) -> list[str]:
    """Three sentences of at most 20 words: whether the recommended gains meet the requirement, what another
    controller would gain, and what is proved and assumed."""
    return [_verdict(study), _gain_of_others(study), _rests_on(study)]


def _verdict(study: Study) -> str:
    """Whether the recommended gains break a limit in any sample or search run."""
    found = list(study.decisions.values())
    if not found:
        return "No controller was judged by the whole requirement."
    samples, runs = (sum(d.evidence[k][n] for d in found) for k, n in
                     (("samples", "total"), ("worst_case", "runs")))  # fmt: skip
    late = max(d.dead_time for d in found)
    with_ = f" with up to {1000 * late:.3g} ms of dead time" if late else ""
    if all(d.holds for d in found):
        return f"These gains meet every limit in {samples} samples and {runs} search runs{with_}."
    broken = sum(d.evidence[k]["broken"] for d in found for k in ("samples", "worst_case"))
    if not broken:
        return f"These gains break a margin limit of the requirement{with_}; see ▲ in the card."
    return f"These gains break a limit in {broken} of {samples + runs} simulated runs{with_}."


def _gain_of_others(study: Study) -> str:
    """How fast the fastest controller within the limits on the nominal plant is beside the recommended."""
    comparison = study.comparison
    motion = study.motions[0]
    of = [s for s in comparison.standings if s.motion == motion]
    own = study.decisions[motion].controller if motion in study.decisions else TUNED
    ours = next((s for s in of if s.controller == own), None)
    ours = ours or next(s for s in of if s.controller == TUNED)
    faster = [s for s in of if s is not ours and not s.breaks]
    best = min(faster, key=lambda s: s.worst_settling_s, default=None)
    if best is None or best.worst_settling_s >= ours.worst_settling_s:
        return f"On the nominal {motion} plant no other controller within the limits settles faster."
    fast, slow = seconds(best.worst_settling_s), seconds(ours.worst_settling_s)
    return (
        f"On the nominal {motion} plant {name_of(best.controller)} settles in {fast}, the "
        f"{name_of(ours.controller)} in {slow}."
    )


def _rests_on(study: Study) -> str:
    """What is proved, and how much is assumed."""
    origins = [p.provenance for s in study.plants.values() for p in s.parameters.values()]
    assumed = sum(isinstance(o, Assumed) for o in origins)
    proofs = [d.evidence["proved"] for d in study.decisions.values()]
    stable = "Stability is proved on the plant as fitted"
    if not proofs or any(p["status"] != Status.PROVED.value for p in proofs):
        stable = "A stability proof is open"
    parameters = f"{assumed} of {len(origins)} plant parameters are assumed"
    return f"{stable}; all else is simulated; {parameters}."


def card_name(d: Decision) -> str:
    """What the card calls a recommended controller: a PI by its structure, as the page of a design does."""
    return pi_name(d.gains) if d.controller == TUNED else name_of(d.controller)


def reason(d: Decision) -> str:
    """Why a controller is recommended, in a few words: how often it was seen to break a limit."""
    c = d.candidates[d.controller]
    broken, total = c["samples_broken"] + c["runs_broken"], c["samples"] + c["runs"]
    return broken_words(broken, total)


def paper_summary(study: Study) -> list[str]:
    """Three sentences of the page of the paper's figures."""
    return [
        f"{len(study.redrawn)} figures of the paper are drawn again by this model.",
        "No recording of the paper's wrist is available, so the model cannot be compared with them point by "
        "point.",
        "The PI's gains are assumed; the bands show the range over the assumed gains.",
    ]


def seconds(value: float) -> str:
    """A settling time [s], or that it is beyond the run."""
    return f"{value:.2f} s" if isfinite(value) else f"more than {WINDOW:g} s"


def on_others(comparison: Comparison, contest: Contest) -> str:
    """Which controller has the least error on the perturbed plants, of those that keep the overshoot."""
    limit = comparison.limits.overshoot_percent
    said, lost = [], []
    for motion in dict.fromkeys(s.motion for s in comparison.standings):
        scores = _played(contest, motion)
        kept = [s for s in scores if limit is None or s.mean["overshoot_percent"] <= limit]
        best = min(kept, key=lambda s: s.mean["iae_deg_s"], default=None)
        if not scores:
            said.append(f"on {motion} none, which was not simulated")
        elif best is None:
            said.append(f"on {motion} none")
        else:
            said.append(_least(best, contest.reference, motion))
            lost += [name_of(best.controller)] if _loses_itself(contest, best) else []
    among = "" if limit is None else f" of the controllers with a mean overshoot of at most {limit:g} %"
    where = "Perturbed plants with a noisy sensor, without unmodelled effects"
    return f"{where}. Least IAE{among}: {'; '.join(said)}.{_but(lost)}"


LATE = next(name for name in RIGS if name.startswith("dead time"))
"""The plant with dead time, as real rigs have."""


def _loses_itself(contest: Contest, best: Score) -> bool:
    """Whether a controller fails to settle on most plants with that dead time."""
    scores = contest.of(best.motion, f"{LATE}{BESIDE}", best.family)
    scores = scores or contest.of(best.motion, LATE, best.family)
    return any(s.mean["unsettled"] > 0.5 for s in scores if s.controller == best.controller)


def _but(lost: list[str]) -> str:
    if not lost:
        return ""
    names, late = list(dict.fromkeys(lost)), LATE.replace("dead time", "a dead time of")
    fails = "fails" if len(names) == 1 else "fail"
    return f" With {late} that no model has, {listed(names)} {fails} to settle on most plants."


def _played(contest: Contest, motion: str) -> list[Score]:
    """The scores of the steps on perturbed plants, with the MPCs where these ran on enough of them."""
    field, family = PERTURBED
    beside = contest.of(motion, f"{field}{BESIDE}", family)
    return beside if beside and beside[0].plants >= FEWEST else contest.of(motion, field, family)


def _least(best: Score, reference: str, motion: str) -> str:
    i, here = best.against["iae_deg_s"], f"on {motion} ({best.plants} plants)"
    if best.controller == reference:
        return f"{here} the {name_of(reference)} itself, {number(best.mean['iae_deg_s'])} deg s"
    level = f"{100 * LEVEL:g} % interval"
    interval = f" ({level} {fixed(i.low, 2)} to {fixed(i.high, 2)})" if isfinite(i.low) else ""
    beside = f"relative to the {name_of(reference)}"
    return f"{here} {name_of(best.controller)}, {fixed(i.mean, 2)} deg s{interval} {beside}"


def misfit(fit: Fit) -> str:
    """Whether the fitted model explains the held-out recordings down to the noise."""
    if fit.remarks:
        return " ".join(fit.remarks)
    return "The errors do not exceed the noise: the model explains these recordings."


def fit_words(fit: Fit) -> str:
    """Which recordings were fitted and which were held out."""
    took = [r.recording.name for r in fit.runs if r.role == "fit"]
    apart = [r.recording.name for r in fit.runs if r.role == "validate"]
    judged = f"judged on {', '.join(apart)}, which were held out" if apart else "no recording was held out"
    return f"Fitted to {', '.join(took)} of the campaign “{fit.campaign.name}”; {judged}."


def found(answer: Answer) -> str:
    """Cost at the tuned gains, where it is taken, and what keeps it from being lower."""
    t = answer.tuning
    unit = COST_WORDS.get(t.problem.cost, "").partition("[")[2].rstrip("]")
    where = t.problem.place("cost", int(t.at.cost_at[0]))
    words = f"Worst cost {number(float(t.at.cost[0]))} {unit}, on {spaced(where)}."
    steps = f"{len(t.problem.scenarios)} steps and"
    if t.given:
        words += (
            f" The gains come from the design, and are shown on {steps} the {len(t.problem.adverse)} hardest "
            "cases of a pool."
        )
    elif t.problem.adverse:
        words += (
            " Every limit is met over the whole stated uncertainty, dead time included: the gains are tuned "
            f"on {steps} {len(t.problem.adverse)} cases found by the worst-case search."
        )
    if answer.refusal is not None:
        return f"{words} The answer is {refused(answer.refusal)}."
    if t.given:
        return f"{words} Nearest limit: {limit_name(str(nearest_limit(t.at, 0)))}."
    if t.active:
        active = [limit_name(n) for n, excess in t.at.excess.items() if excess[0] > -ACTIVE]
        return f"{words} Active limit{'s' * (len(active) > 1)}: {' and '.join(active)}."
    return f"{words} No limit is active."


def evidence(answer: Answer) -> str:
    """Why the gains are taken for the global optimum."""
    t = answer.tuning
    region, ratio = t.region, t.region.resolution
    ends = [s.cost for s in t.searches if s.feasible]
    near = sum(c <= 1.01 * float(t.at.cost[0]) for c in ends)
    if t.given:
        return (
            f"No search was made here: the map of {region.points} × {region.points} gains shows those of the "
            "design. It uses the limits themselves and fewer cases than the design, so neighbouring gains "
            "may appear to meet them at lower cost."
        )
    held = "none met the limits"
    head = "What was searched" if answer.refusal else "Evidence that this is the global optimum"
    if ends:
        held = f"{len(ends)} ended where every limit is met, {near} of them within 1 % of the cost above"
    words = (
        f"{head}: a map of {region.points} × {region.points} gains covers "
        f"Kp from {region.Kp[0]:g} to {region.Kp[1]:g} kPa/deg and Ki from {region.Ki[0]:g} to "
        f"{region.Ki[1]:g} kPa/(deg s) in steps of {100 * (ratio[0] - 1):.0f} % and "
        f"{100 * (ratio[1] - 1):.0f} %. Of {len(t.searches)} local searches from its minima "
        f"and other cells, {held}. "
        "Three successively finer maps around the best point lead to these gains."
    )
    if t.problem.set_aside:
        words += (
            f" {len(t.problem.set_aside)} of {len(t.problem.scenarios) + len(t.problem.set_aside)} scenarios "
            f"were set aside, such as {spaced(t.problem.set_aside[0].name)}: the command that holds them "
            f"lies within {HEADROOM:g} V of the end of the range, or beyond it."
        )
    edge = " The optimum lies on the edge of the searched region: a wider region may contain a better one."
    return words + (edge if t.on_edge else "")
