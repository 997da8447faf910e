"""What the page of robustness says in sentences: summary, captions, assumptions."""

from collections.abc import Mapping

from design.robustness.assess import Assessment
from design.robustness.certificates.certificate import Switching
from design.robustness.certificates.constant.robust_stability import StableWhileConstant
from design.robustness.certificates.statements import (
    LeavesVirginCurve,
    StaysInRange,
    TasksDieAway,
    Unclipped,
)
from design.robustness.samples.statements import LEVEL
from design.status import Status
from design.studies.limits_matrix import CONDITIONS
from design.studies.robustness_study import RobustnessStudy
from design.synthesis.requirements import LIMIT_UNITS
from reports.robustness.statements import because, claim_words, class_words
from reports.robustness.tables import limit_words
from reports.shared.card import CardRow
from reports.shared.tables import number, spaced


def title(a: Assessment) -> str:
    """The heading: in a few words what became of the gains, which stand in the card."""
    if not a.stable:
        return "The loop is unstable on some branch"
    broken = [s for s in (*a.predictions, *a.samples) if s.holds is False]
    if broken:
        few = "one statement does" if len(broken) == 1 else f"{len(broken)} statements do"
        return f"Of these gains {few} not hold"
    if a.required.broken:
        return f"These gains break a limit in {a.required.broken} of {a.required.total} samples"
    if a.worst.violated:
        return "These gains break a limit in the worst case found"
    if _not_met(a):
        return "These gains break a limit of the linear loop"
    return "These gains meet all limits, in samples, margins and the worst case found"


def answer(a: Assessment) -> str:
    """The verdict in one line: whether the gains meet the limits, and what breaks one.

    At most 20 words; what it rests on stands in `details`.
    """
    if not a.stable:
        return "No: by linear theory the loop is unstable on some branch of the hysteresis."
    found = [f"{a.required.broken} of {a.required.total} samples break a limit"]
    if a.worst.violated:
        found.append(f"worst case found: {beyond(a)}")
    linear = _not_met(a)
    if linear:
        found.append(f"{' and '.join(linear)} not met on some branch")
    met = not (a.required.broken or a.worst.violated or linear)
    return f"{'Yes' if met else 'No'}: {'; '.join(found)}."


def _not_met(a: Assessment) -> list[str]:
    """Limits of the linear loop that some branch breaks, in words."""
    return [MARGINS_WORDS[n] for n in MARGINS_WORDS if margin_met(a, n) is False]


MARGINS_WORDS = {"Ms": "Ms", "Mt": "Mt", "delay_margin_s": "delay margin"}
"""Limits of the linear loop by the keys of a row of margins."""


def margin(a: Assessment, name: str) -> float:
    """The worst margin over branches and rates."""
    values = [float(row[name]) for row in a.margins]
    return min(values) if name == "delay_margin_s" else max(values)


def margin_met(a: Assessment, name: str) -> bool | None:
    """Whether a limit of the linear loop is met on every branch; None where none is set."""
    limit = a.limits.named.get(name)
    if limit is None:
        return None
    return margin(a, name) >= limit if name == "delay_margin_s" else margin(a, name) <= limit


def summary(a: Assessment) -> list[str]:
    """Three sentences of at most 20 words: the verdict, the margins, what is proved."""
    return [answer(a), _margins(a), _proof(a)]


def _margins(a: Assessment) -> str:
    """Ms and delay margin in a sentence."""
    if not a.stable:
        return "Margins of an unstable loop mean nothing."
    named = a.limits.named
    return (
        f"Worst branch: Ms is {number(margin(a, 'Ms'))}{_of(named, 'Ms', 1.0, '')}, the delay margin "
        f"{1000 * margin(a, 'delay_margin_s'):.0f} ms{_of(named, 'delay_margin_s', 1e3, ' ms')}."
    )


def _proof(a: Assessment) -> str:
    """What is proved of the tasks, or else of the switching loop."""
    tasks = [s for s in a.certificates if isinstance(s.claim, TasksDieAway) and s.holds]
    switched = [c for c in a.ladder if c.holds and not c.remembers]
    if tasks:
        rate = min(s.value for s in tasks if s.value is not None)
        late = max(float(s.evidence["dead_time_s"]) for s in tasks)
        about = "for the task on the nominal plant"
    elif switched:
        best = max(switched, key=lambda c: (c.dead_time, c.decay or 0.0))
        rate, late, about = best.decay or 0.0, best.dead_time, "for any switching of the slope"
    else:
        return "Open: no certificate of stability was found for a loop that switches between branches."
    behind = f"{1000 * late:g} ms of dead time" if late else "no dead time"
    return f"Proved: exponentially stable, rate at least {number(rate, 2)} 1/s, {about}, {behind}."


def details(a: Assessment) -> list[str]:
    """The same in full: what samples showed, what linear theory predicts, what is proved."""
    return [seen(a), foreseen(a), proved(a)]


def card_row(study: RobustnessStudy) -> CardRow:
    """The limits of an assessment by what they are judged under."""
    a = study.assessment
    rows = []
    for name, bound in a.limits.named.items():
        values: dict[str, float | None] = dict.fromkeys(CONDITIONS)
        if name in MARGINS_WORDS:
            values["every branch and memory"] = margin(a, name) if a.stable else float("inf")
        else:
            values["perturbed plants"] = float(a.required.values[name].max())
            values["worst case found"] = float(a.worst.values[name])
        held = {
            c: None if v is None else (v >= bound if name == "delay_margin_s" else v <= bound)
            for c, v in values.items()
        }
        rows.append({"limit": name, "bound": bound, "values": values, "held": held})
    tasks = [s for s in a.certificates if isinstance(s.claim, TasksDieAway) and s.holds]
    rate = min((s.value for s in tasks if s.value is not None), default=None)
    late = max((float(s.evidence["dead_time_s"]) for s in tasks), default=0.0)
    status = Status.PROVED if tasks else Status.OPEN
    proved = {"status": status.value, "rate_1_s": rate, "dead_time_s": late}
    c = a.controller
    gains = {
        "Kp": float(c.Kp), "Ki": float(c.Ki), "b": float(getattr(c, "b", 1.0)),
        "Tf": float(getattr(c, "Tf", 0.0)),
    }  # fmt: skip
    return CardRow(a.box.plant.axis, "PI", gains, rows, proved, {})


def seen(a: Assessment) -> str:
    """What samples and the search say."""
    cases = a.cases
    broken = [v for v in cases.violations if v.count]
    if broken:
        worst = max(broken, key=lambda v: v.count)
        words = (
            f"Of {worst.trials} independent simulated cases {worst.count} break the requirement broken most "
            f"({worst.words}), which is {number(100 * worst.low, 2)} to {number(100 * worst.high, 2)} % of "
            "cases at 95 % confidence"
        )
    else:
        words = f"None of {len(cases)} independent simulated cases breaks a requirement"
    return f"{words}, {'and' if bool(broken) == bool(a.worst.violated) else 'but'} {worst_phrase(a)}."


def foreseen(a: Assessment) -> str:
    """What predictions say."""
    if not a.stable:
        unstable = [row for row in a.margins if not row["stable"]]
        places = ", ".join(dict.fromkeys(f"{spaced(r['branch'])} ({r['rate']} rate)" for r in unstable))
        return f"By linear theory the loop is unstable on {places} of the hysteresis."
    Ms = max(float(r["Ms"]) for r in a.margins)
    late = min(float(r["delay_margin_s"]) for r in a.margins)
    limits = a.limits.named
    words = (
        "By linear theory, on every branch of the hysteresis, whether the regulator is fast or slow, the "
        f"peak of the sensitivity Ms is at most {number(Ms)}{_of(limits, 'Ms', 1.0, '')} and the delay "
        f"margin at least {1000 * late:.0f} ms{_of(limits, 'delay_margin_s', 1e3, ' ms')}"
    )
    there = [c for c in a.cycles if c.confirmed]
    if there:
        words += (
            f", but {len(there)} lasting oscillation{'s are' if len(there) > 1 else ' is'} predicted and "
            "there in simulation"
        )
    return words + "."


def _of(limits: Mapping[str, float], name: str, scale: float, unit: str) -> str:
    """The limit that a value is held against, in brackets, where there is one."""
    return f" (limit: {number(scale * limits[name])}{unit})" if name in limits else ""


def proved(a: Assessment) -> str:
    """What certificates say."""
    held = [c for c in a.ladder if c.holds and not c.remembers]
    if held:
        late = [c for c in held if c.dead_time]
        best = max(late or held, key=lambda c: c.decay or 0.0)
        dead_time = (
            f"with {1000 * best.dead_time:g} ms of dead time too" if late else "without added dead time only"
        )
        words = (
            "It is proved that, while the command is not clipped, the loop is exponentially stable with rate "
            f"{number(best.decay, 2)} 1/s or faster however the loop switches between the slopes of the "
            f"branches, {dead_time} ({best.rung})"
        )
    else:
        words = (
            "No certificate knows the law of this loop"
            if a.other_law
            else ("No certificate was found for a loop that switches arbitrarily between branches")
        )
        words += "; a destabilising switching sequence exists" if a.word is not None else ""
    words += _of_tasks(a)
    constant = [s for s in a.certificates if isinstance(s.claim, StableWhileConstant)]
    if constant and all(s.holds for s in constant):
        least = min(s.value for s in constant if s.value is not None)
        words += (
            f"; with constant parameters it is proved stable in a box {number(least)} times as wide as the "
            "one assumed"
        )
    return words + "."


def _of_tasks(a: Assessment) -> str:
    """What is proved of the tasks as they are, in half a sentence."""
    held = [s for s in a.certificates if isinstance(s.claim, TasksDieAway) and s.holds]
    if not held:
        return ""
    least = min(s.value for s in held if s.value is not None)
    late = max(float(s.evidence["latest_s"]) for s in held)
    behind = max(float(s.evidence["dead_time_s"]) for s in held)
    tube = f", with {1000 * behind:g} ms of dead time too" if behind else ", without dead time"
    words = (
        f"; for the sampled loop with hysteresis and command range every run of the task enters, within "
        f"{number(late)} s, a set in which it is exponentially stable with rate at least "
        f"{number(least, 2)} 1/s{tube}"
    )
    of_box = [c.decay for c in a.ladder if c.about and c.about.switching is Switching.MEMORY_IN_BOX]
    if of_box and all(d is not None for d in of_box):
        slow = min(d for d in of_box if d is not None)
        words += f" (on any plant of the box, once at most one line is met, with rate {number(slow, 2)} 1/s)"
    return words


def worst_phrase(a: Assessment) -> str:
    """The worst scenario in half a sentence."""
    w = a.worst
    if w.violated:
        return f"a search of {w.evaluations} runs for the worst scenario found {_article(beyond(a))}"
    return f"a search of {w.evaluations} runs for the worst scenario found none that breaks a limit"


def _article(words: str) -> str:
    """Words with "a" or "an" before them.

    >>> _article("overshoot of 6 %"), _article("travel of 17 V")
    ('an overshoot of 6 %', 'a travel of 17 V')
    """
    return f"{'an' if words[0] in 'aeiouAEIOU' or words.startswith('Ms') else 'a'} {words}"


def beyond(a: Assessment) -> str:
    """What the worst scenario breaks: value and limit."""
    name = a.worst.excess_of
    unit = LIMIT_UNITS[name]
    value, limit = number(a.worst.values[name]), number(a.limits.named[name])
    return f"{limit_name(name)} of {value} {unit} against a limit of {limit} {unit}"


def limit_name(name: str) -> str:
    """A limit by the words for it.

    >>> limit_name("steady_error_percent")
    'steady error'
    """
    return name.rsplit("_", 1)[0].replace("_", " ")


def plane_caption(a: Assessment) -> str:
    """Beneath the plane of the gains."""
    return (
        "Gain plane. Star: these gains. Below the lines the limits are met. Cross-hatched: unstable on some "
        "branch. Filled: certified for arbitrarily switching slopes, by the rung named; with a fixed law of "
        "the regulator the region is larger. Ms and delay margin: linear loops; overshoot: worst simulated "
        "tuning scenario. Edges are interpolated between grid points."
    )


SIGNATURE = (
    "These gains beside SIMC's. Columns above: branches of the hysteresis at both regulator rates; disc: Ms "
    "beyond its limit. Below: the step from each initial hysteresis state."
)
LATE = (
    "Worst overshoot over both signs and all initial states against added dead time, nominal plant. A curve "
    "ends where the loop no longer settles."
)
NYQUIST = (
    "Nyquist curves of the open loop on all branches and rates. Grey disc about −1: Ms above 2. Branches "
    "differ in slope alone, so at one rate their curves are scaled copies of each other."
)
SENSITIVITIES = (
    "Sensitivity |S| (disturbance to angle error) and complementary sensitivity |T| (noise to angle) on "
    "every branch and rate. Dashed: limits."
)
DESCRIBING = (
    "Harmonic balance: a limit cycle is predicted where a coloured curve, the linear part of the loop, "
    "crosses the black one, −1/N(A) of the hysteresis at pressure amplitude A."
)
NO_CYCLES = (
    "No limit cycle is predicted. What simulations from large amplitudes show stands in the first table."
)
ENVELOPE = (
    "True angle of the cases, drawn upwards: median and the band of 90 % of them. Below: the same near the "
    "reference; dotted: settling band."
)


def model_words(a: Assessment) -> str:
    """What the certificates are about."""
    words = (
        "While the command is not clipped the loop has three states (error, static angle less angle, "
        "commanded less actual "
        "pressure), is linear in the slope of the branch, and has no offsets; the rungs below prove "
        "exponential stability of these states on whichever branch the wrist is and whenever it changes. The "
        "virgin curve, of slope 0, is left once and never entered again; that time is bounded separately."
    )
    model = a.left_out
    if model:
        words += f" The plant also has {', '.join(model)}, which the certificates do not include."
    return words


def claims(a: Assessment) -> list[str]:
    """What each rung claims, those of the sampled loop together; and the word that speaks against some."""
    found: dict[str, list[str]] = {}
    for c in a.ladder:
        if not c.dead_time:
            about = "" if c.about is None else class_words(c.about)
            found.setdefault(about, []).append(c.rung)
    said = [f"{_start(', '.join(rungs))}: {claim}." for claim, rungs in found.items()]
    if a.word is not None:
        said.append(
            f"Where the rate switches too, a destabilising switching sequence exists: {a.word}. It is of the "
            "class, not of the wrist, whose rate follows the error of the pressure."
        )
    return said


def region(a: Assessment) -> list[str]:
    """What is certified of the step itself."""
    found = []
    for s in a.certificates:
        if isinstance(s.claim, LeavesVirginCurve):
            time = "–" if s.value is None else f"{1000 * s.value:.3g} ms"
            found.append(f"{_start(claim_words(s.claim))}: {time} at most ({because(s)}).")
        elif isinstance(s.claim, TasksDieAway):
            rate = "not proved" if s.value is None else f"{number(s.value)} 1/s"
            found.append(f"{_start(claim_words(s.claim))}: {rate} ({because(s)}).")
        elif isinstance(s.claim, StaysInRange):
            verdict = "proved" if s.holds else "not proved"
            if not isinstance(s.reason, Unclipped):
                verdict += f"; steps up to {number(s.value)} deg are covered"
            found.append(f"{_start(claim_words(s.claim))}: {verdict} ({because(s)}).")
    return found


def _start(words: str) -> str:
    return words[0].upper() + words[1:]


def sample_words(a: Assessment) -> str:
    """How the samples were drawn."""
    c, cases = a.conditions, a.cases
    parts = [
        f"{len(cases)} cases, independent: a plant from the box below, one of four starting memories, "
        "either sign of the step"
    ]
    parts += [f"dead time up to {1000 * c.dead_time:g} ms"] if c.dead_time else []
    parts += [f"a constant load of up to ±{c.load:g} deg"] if c.load else []
    parts += [f"sensor noise of {c.noise:g} deg (s.d.) at 100 Hz"] if c.noise else []
    parts += [f"a sensor that steps by {c.quantum:g} deg"] if c.quantum else []
    words = ", ".join(parts) + ". A statement holds where the whole interval is below "
    words += f"{100 * LEVEL:g} % of cases, and is open where the interval holds that figure."
    return words + "".join(f" {r[0].upper() + r[1:]}." for r in cases.remarks)


def worst_words(a: Assessment) -> str:
    """The worst scenario in full."""
    w = a.worst
    what = (
        f"It has {beyond(a)}."
        if w.violated
        else f"It breaks no limit; it is the one with the largest IAE per degree, {number(w.cost_per_deg)} s."
    )
    return (
        f"References in turn, in brackets how long each is held: {spaced(w.sequence.name)}. {what} Found in "
        f"{w.evaluations} runs by differential evolution and Nelder-Mead over the box, the starting memory, "
        "three references and how long they are held; a lower bound of the true worst case, no proof that "
        "there is none worse."
    )


def worst_caption(a: Assessment) -> str:
    """Beneath the worst scenario."""
    m = a.worst.metrics
    return (
        "The worst scenario that was found, played by the exact simulator. The last step, shaded, is "
        f"judged: overshoot {number(m['overshoot_percent'], 2)} %, error at the end "
        f"{number(m['steady_state_error_deg'], 2)} deg, total variation of the command "
        f"{number(m['total_variation_V'], 3)} V."
    )


def assumptions(a: Assessment) -> list[str]:
    """What stands beside parameters."""
    low, high = a.wrist.rig.command_range
    found = [
        f"Limits: {limit_words(a.limits)}.",
        f"The command is clipped at {low:g} and {high:g} V; certificates hold where it is not.",
        "Boxes of fitted parameters leave out their correlations.",
        "Dead time, load, noise and resolution of the samples are assumed: orders typical of such rigs.",
    ]
    return found


def remarks(a: Assessment) -> list[str]:
    """What a reader has to know before all else."""
    said = []
    if a.other_law:
        said.append(
            f"The controller has {a.other_law}, which no certificate knows: all of them are open. "
            "Predictions and samples do know it."
        )
    if not a.left_out:
        return said
    return [
        *said,
        f"Certificates do not include the effects {', '.join(a.left_out)}: they hold for the declared wrist "
        "with these parameters. Predictions and samples include them.",
    ]
