"""What the page of robustness says in sentences: title, verdict, summary, remarks."""

from collections.abc import Mapping

from design.robustness.assess import Assessment
from design.robustness.certificates.certificate import Switching
from design.robustness.certificates.constant.robust_stability import StableWhileConstant
from design.robustness.certificates.statements import (
    TasksDieAway,
)
from design.status import Status
from design.studies.robustness_study import RobustnessStudy
from design.studies.shown.limits_matrix import CONDITIONS
from design.synthesis.requirements import LIMIT_UNITS
from plants.effects.wrist.remainder import ColouredRemainder
from reports.shared.card import CardRow
from reports.shared.names import pi_name
from reports.shared.tables import number, spaced


def title(a: Assessment) -> str:
    """The heading: in a few words what became of the gains, which stand in the card."""
    if not a.stable:
        return "The loop is unstable on some branch"
    broken = [s for s in (*a.predictions, *a.samples) if s.holds is False]
    if broken:
        few = "One statement" if len(broken) == 1 else f"{len(broken)} statements"
        return f"{few} about these gains {'does' if len(broken) == 1 else 'do'} not hold"
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


MARGINS_WORDS = {"Ms": "Ms", "Mt": "Mt", "delay_margin_s": "delay margin", "WT": "|W T|"}
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
        return "An unstable loop has no margins."
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
        about = "for tasks on the nominal plant"
    elif switched:
        best = max(switched, key=lambda c: (c.dead_time, c.decay or 0.0))
        rate, late, about = best.decay or 0.0, best.dead_time, "for any switching of the slope"
    else:
        return "Open: no certificate of stability was found for a loop that switches between branches."
    behind = f"with {1000 * late:.3g} ms of dead time" if late else "without dead time"
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
    return CardRow(a.box.plant.axis, pi_name(gains), gains, rows, proved, {})


def seen(a: Assessment) -> str:
    """What samples and the search say."""
    cases = a.cases
    broken = [v for v in cases.violations if v.count]
    if broken:
        worst = max(broken, key=lambda v: v.count)
        words = (
            f"{worst.count} of {worst.trials} independent simulated single steps break the most critical "
            "requirement "
            f"({worst.words}): {number(100 * worst.low, 2)} to {number(100 * worst.high, 2)} % of cases at "
            "95 % confidence"
        )
    else:
        words = f"None of {len(cases)} independent simulated single steps breaks a requirement"
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
        "Predicted by linear theory on every branch of the hysteresis, at every regulator rate: the "
        f"sensitivity peak Ms is at most {number(Ms)}{_of(limits, 'Ms', 1.0, '')} and the delay margin at "
        f"least {1000 * late:.0f} ms{_of(limits, 'delay_margin_s', 1e3, ' ms')}"
    )
    there = [c for c in a.cycles if c.confirmed]
    if there:
        words += (
            f", but {len(there)} sustained oscillation{'s are' if len(there) > 1 else ' is'} predicted and "
            "confirmed in simulation"
        )
    return words + "."


def _of(limits: Mapping[str, float], name: str, scale: float, unit: str) -> str:
    """The limit of a value in brackets, where there is one."""
    return f" (limit: {number(scale * limits[name])}{unit})" if name in limits else ""


def proved(a: Assessment) -> str:
    """What certificates say."""
    held = [c for c in a.ladder if c.holds and not c.remembers]
    if held:
        late = [c for c in held if c.dead_time]
        best = max(late or held, key=lambda c: c.decay or 0.0)
        dead_time = (
            f"also with {1000 * best.dead_time:.3g} ms of dead time"
            if late
            else "only without added dead time"
        )
        words = (
            "Proved: while the command is not clipped, the loop is exponentially stable with rate at least "
            f"{number(best.decay, 2)} 1/s under arbitrary switching between the slopes of the branches, "
            f"{dead_time} ({best.rung})"
        )
    else:
        words = (
            "No certificate covers the law of this controller"
            if a.other_law
            else "No certificate was found for a loop that switches arbitrarily between branches"
        )
        words += "; a destabilising switching sequence exists" if a.word is not None else ""
    words += _of_tasks(a)
    constant = [s for s in a.certificates if isinstance(s.claim, StableWhileConstant)]
    if constant and all(s.holds for s in constant):
        least = min(s.value for s in constant if s.value is not None)
        words += (
            f". For constant parameters stability is proved in a box {number(least)} times as wide as the "
            "assumed one"
        )
    return words + "."


def _of_tasks(a: Assessment) -> str:
    """What is proved of the tasks, in a sentence or two without the last full stop."""
    held = [s for s in a.certificates if isinstance(s.claim, TasksDieAway) and s.holds]
    if not held:
        return ""
    least = min(s.value for s in held if s.value is not None)
    late = max(float(s.evidence["latest_s"]) for s in held)
    behind = max(float(s.evidence["dead_time_s"]) for s in held)
    tube = f", also with {1000 * behind:.3g} ms of dead time" if behind else ", without dead time"
    words = (
        f". In the sampled loop, with hysteresis and command range, every run of the task enters within "
        f"{number(late)} s a set in which it is exponentially stable with rate at least "
        f"{number(least, 2)} 1/s{tube}"
    )
    of_box = [c.decay for c in a.ladder if c.about and c.about.switching is Switching.MEMORY_IN_BOX]
    if of_box and all(d is not None for d in of_box):
        slow = min(d for d in of_box if d is not None)
        left = ColouredRemainder.of(a.box.plant.remainder.get("angle_deg"))
        more = (
            f", its slopes changed by up to {number(100 * left.steepest, 2)} % by the residual,"
            if left
            else ""
        )
        words += (
            f". On every plant of the box{more} the rate is {number(slow, 2)} 1/s while at most one line is "
            "met"
        )
    return words


def worst_phrase(a: Assessment) -> str:
    """The worst scenario in half a sentence."""
    w = a.worst
    if w.violated:
        return f"a search of {w.evaluations} runs for the worst scenario found {_article(beyond(a))}"
    return f"a search of {w.evaluations} runs for the worst scenario found none that breaks a limit"


def _article(words: str) -> str:
    """Words with their article.

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


def remarks(a: Assessment) -> list[str]:
    """What a reader has to know before all else."""
    said = []
    if a.other_law:
        said.append(
            f"The controller has {a.other_law}, which no certificate covers: all certificates are open. "
            "Predictions and samples include it."
        )
    if a.left_out:
        said.append(
            f"Certificates do not include the effects {', '.join(a.left_out)}: they hold for the declared "
            "wrist with these parameters. Predictions and samples include them."
        )
    return said
