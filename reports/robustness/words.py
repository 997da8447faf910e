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
from design.synthesis.requirements import LIMIT_UNITS
from reports.robustness.statements import because, claim_words, class_words
from reports.robustness.tables import limit_words
from reports.shared.tables import number, spaced


def title(a: Assessment) -> str:
    """The heading: the gains, and in a few words what became of them."""
    gains = (
        f"Kp = {number(float(a.controller.Kp))} kPa/deg, Ki = {number(float(a.controller.Ki))} kPa/(deg s)"
    )
    if not a.stable:
        return f"{gains}: unstable on some branch"
    broken = [s for s in (*a.predictions, *a.samples) if s.holds is False]
    if broken:
        return f"{gains}: " + (
            "one statement does not hold" if len(broken) == 1 else f"{len(broken)} statements do not hold"
        )
    if a.worst.violated:
        return f"{gains}: meets all limits in random cases; the worst-case search finds a violation"
    return f"{gains}: meets all limits"


def summary(a: Assessment) -> list[str]:
    """Three sentences: what was seen, what theory foresees, what is proved."""
    return [seen(a), foreseen(a), proved(a)]


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
        f"peak of the sensitivity Ms is at most {number(Ms)}{_of(limits, 'Ms', 1.0, '')} and the loop "
        f"bears at least {1000 * late:.0f} ms more dead time{_of(limits, 'delay_margin_s', 1e3, ' ms')}"
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
            f"with {1000 * best.dead_time:g} ms of dead time too"
            if late
            else "though not with dead time on top"
        )
        words = (
            "It is proved that, while the command is not clipped, the loop is exponentially stable with rate "
            f"{number(best.decay, 2)} 1/s or faster however the loop switches between the slopes of the "
            f"branches, {dead_time} ({best.rung})"
        )
    else:
        words = "Nothing is proved of a loop that switches between branches at will: no certificate was found"
        words += ", and none exists where the regulator's rate switches too" if a.word is not None else ""
    words += _of_tasks(a)
    constant = [s for s in a.certificates if isinstance(s.claim, StableWhileConstant)]
    if constant and all(s.holds for s in constant):
        least = min(s.value for s in constant if s.value is not None)
        words += (
            f"; with parameters that stay constant it is proved stable in a box {number(least)} times as "
            "wide as the one assumed"
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
        f"; with the loop's own memory, sampled and with the command's range, every run of the task comes "
        f"within {number(late)} s to where it is proved to decay at {number(least, 2)} 1/s for ever{tube}"
    )
    of_box = [c.decay for c in a.ladder if c.about and c.about.switching is Switching.MEMORY_IN_BOX]
    if of_box and all(d is not None for d in of_box):
        slow = min(d for d in of_box if d is not None)
        words += f" (on any plant of the box, once it meets one line at most, at {number(slow, 2)} 1/s)"
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
        "What each kind of statement allows. See whether the star lies below the lines of the limits and "
        "within what is certified: the further below, the more the gains bear. Cross-hatched: unstable on "
        "some branch. Filled: certified for slopes that switch at any time, by the rung named; the one "
        "that knows the regulator's law to be fixed reaches further. Ms and delay margin are those of the "
        "linear loops, overshoot the worst of the simulated tuning scenarios. Between grid points the "
        "edges are drawn, not computed."
    )


NYQUIST = (
    "Nyquist curves of the open loop on all branches and rates. See that none enters the grey disc about −1: "
    "one that does has a peak of the sensitivity above 2. The branches of the hysteresis differ in slope "
    "alone, so that at one rate their curves are one curve at several sizes."
)
SENSITIVITIES = (
    "Sensitivity |S|, how far disturbances are let through, and complementary sensitivity |T|, how far noise "
    "is, on every branch and rate. See how far the curves stay below the dashed limits."
)
DESCRIBING = (
    "Harmonic balance. See whether a coloured curve, of the linear part of the loop, meets the black one, "
    "−1/N(A) of the hysteresis for swings of the pressure of amplitude A: where they meet, an oscillation of "
    "that amplitude is predicted."
)
NO_CYCLES = (
    "No limit cycle is predicted. Whether simulations from large swings found one is said in the first table."
)
ENVELOPE = (
    "True angle of the cases, in the direction of the step: the median, and the band that holds 90 % of "
    "them. See in the lower panel, the same near the reference, when the band comes to stay within the "
    "dotted lines of the settling band."
)


def model_words(a: Assessment) -> str:
    """What the certificates are about."""
    words = (
        "While the command is not clipped the loop has three states (error, static angle less angle, "
        "commanded less actual "
        "pressure), is linear in the slope of the branch, and has no offsets; the rungs below prove that "
        "these states die "
        "away whichever branch the wrist is on and whenever it changes. The virgin curve, whose slope is "
        "0, is left once and "
        "never entered again: how long that takes is bounded apart."
    )
    model = a.left_out
    if model:
        words += f" The plant also has {', '.join(model)}, of which the certificates know nothing."
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
        f"{len(cases)} cases, each drawn apart: a plant from the box below, one of four starting memories, "
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
        "The worst scenario that was found, played by the exact simulator. See the last step, shaded, which "
        f"is judged: overshoot {number(m['overshoot_percent'], 2)} %, error at the end "
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
        "Dead time, load, noise and resolution of the samples are assumed: orders that rigs of this kind "
        "show.",
    ]
    return found


def remarks(a: Assessment) -> list[str]:
    """What a reader has to know before all else."""
    if not a.left_out:
        return []
    return [
        f"The plant has effects that the certificates know nothing of ({', '.join(a.left_out)}): they are "
        "of the declared "
        "wrist with these parameters. Predictions and samples do know them."
    ]
