"""Why claims hold or do not, in words."""

from design.robustness.assess import UnstableCentre
from design.robustness.certificates.constant.mu_sweep import Gap, HoldsBarely, NoBound
from design.robustness.certificates.constant.robust_stability import (
    Centre,
    MuBounds,
    Refuted,
    RobustStability,
)
from design.robustness.certificates.constant.uncertain_loop import NAMES
from design.robustness.certificates.continuous.virgin import VirginBounds
from design.robustness.certificates.reasons import (
    NoCertificate,
    NoneOfThisKind,
    NoSolver,
    NotConfirmed,
    NotOnePlay,
    OtherLaw,
    UnstableBranch,
    UnstableMode,
)
from design.robustness.certificates.statements import (
    Arrive,
    Confirmed,
    Covered,
    NoneFound,
    NotFound,
    Unclipped,
    VirginTimes,
)
from design.robustness.predictions.limit_cycles import (
    Balanced,
    LimitCycle,
    Simulated,
)
from design.robustness.predictions.margins import MarginHeld, OfRows, StableEverywhere
from design.robustness.samples.statements import Counted
from design.robustness.statement import Reason, Statement


def because(s: Statement) -> str:
    """Why a statement holds or does not, or how its figure was checked."""
    match s.claim:
        case StableEverywhere():
            return "poles, or, with dead time, Nyquist's criterion; no switching is considered"
        case MarginHeld(_, _, None):
            return f"{reason_words(s.reason)}; no limit is set"
    return reason_words(s.reason)


def reason_words(reason: Reason) -> str:
    """A reason in words."""
    match reason:
        case Confirmed(solver, margin, left_out, name):
            words = f"{name}, " if name else ""
            words += f"found by {solver}, checked independently"
            words += "" if margin is None else f" with a margin of {margin:.2g}"
            return words + (f"; for the wrist without {', '.join(left_out)}" if left_out else "")
        case NotFound(why, word):
            none = "" if word is None else f"; none exists: {word} (in the class, not in the real loop)"
            return no_certificate(why) + none
        case NoneFound(names, word):
            none = "" if word is None else "; none exists: a destabilising switching sequence is known"
            return f"none found ({', '.join(names)}){none}"
        case Covered(rung):
            return f"{rung}: steps up to this size start in an invariant set where the command is not clipped"
        case Arrive():
            return arrive_words(reason)
        case Unclipped(rung, runs):
            return (
                f"none of {runs} runs of the task clips the command, before or after it enters the set of "
                f"the certificate ({rung})"
            )
        case VirginTimes(bounds):
            return virgin_words(bounds)
        case UnstableCentre(said):
            return said
        case OfRows():
            return "worst of the branches and rates"
        case Balanced(attract, repel, swings):
            return (
                f"harmonic balance: {attract} stable and {repel} unstable limit cycles; {swings.lanes} "
                f"simulations from large amplitudes, {swings.duration:g} s each: {swings.persisting} keep "
                "oscillating"
            )
        case Simulated(cycle):
            return cycle_words(cycle)
        case Counted(v, noisy, uncounted):
            words = (
                f"{v.count} of {v.trials} independent samples, {100 * v.probability:.3g} %; "
                f"95 % interval {100 * v.low:.3g} to {100 * v.high:.3g} %"
            )
            words += "; sensor noise also moves the command" if noisy else ""
            return words + (f"; {uncounted} cases out of reach not counted" if uncounted else "")
        case MuBounds(row):
            return mu_words(row)
    raise TypeError(f"no words for {reason!r}")


def arrive_words(r: Arrive) -> str:
    """How the runs of the tasks enter the set in which the loop decays."""
    words = f"{r.arrive} of {r.runs} runs"
    if r.latest is not None and r.off is not None:
        words += (
            f" enter within {r.latest:.3g} s a set in which at most one line and no command limit is met "
            f"again; the static angle is at most {r.off:.2g} deg off (certificate: {r.rung})"
        )
    words += f"; the slowest pole decays at {r.slowest:.3g} 1/s; {r.clipped} runs clip the command before"
    return words + (f"; for the wrist without {', '.join(r.left_out)}" if r.left_out else "")


def mu_words(r: RobustStability) -> str:
    """What the bounds of mu say of a branch at a rate."""
    if r.reason is Centre.UNSTABLE:
        return Centre.UNSTABLE.value
    if r.upper == 0.0:
        return "no parameter of this loop is uncertain, and it is stable"
    said = f"mixed mu at most {r.upper:.4g}"
    if r.certified:
        said += f", {r.intervals} intervals cover all frequencies, each checked with margin {r.margin:.1e}"
    else:
        said += f" only at the frequencies examined: {_uncovered(r)}"
    if r.destabilising is not None:
        p = r.destabilising.parameters
        names = [n for n, radius in zip(NAMES, r.loop.radius, strict=True) if radius > 0.0]
        at = ", ".join(f"{n} {p[n]:.4g}" for n in names)
        said += f"; unstable at {at}, in the box enlarged {r.destabilising.growth:.4g} times"
        if r.destabilising.dynamics is not None:
            said += f", with unmodelled dynamics at {r.destabilising.root.imag:.3g} rad/s"
    said += "; in continuous time"
    return said + (f"; without {', '.join(r.left_out)}" if r.left_out else "")


def _uncovered(r: RobustStability) -> str:
    """Why the bound of mu is not proved at every frequency."""
    match r.reason:
        case Gap(tried, low, high):
            return f"{tried} matrix inequalities left a gap from {low:.4g} to {high:.4g} rad/s"
        case NoBound(at):
            return f"no bound at {at:.4g} rad/s"
        case HoldsBarely(share):
            return f"the inequality holds by only {share:.2g} when checked again"
        case Refuted() | Centre():
            return str(r.reason.value)
        case None:
            return ""


def no_certificate(reason: NoCertificate | None) -> str:
    """Why no certificate of a kind was found."""
    match reason:
        case UnstableBranch(branch, rate, pole):
            return f"the linear loop on {branch} at the {rate} rate has a pole at {pole:.3g} 1/s"
        case UnstableMode():
            return "one branch at one rate is unstable on its own"
        case NotOnePlay():
            return "the hysteresis is not one play between two straight lines"
        case OtherLaw(has):
            return f"the controller has {has}, which no certificate covers"
        case NoSolver(said):
            return f"no solver found one: {said}"
        case NoneOfThisKind(solver, margin, ""):
            return f"none of this kind: the best solution of {solver} violates an inequality ({margin:.2g})"
        case NoneOfThisKind(solver, margin, what):
            return f"{solver}: no such {what} (at best by {margin:.1e})"
        case NotConfirmed(solver, margin):
            return f"not confirmed: {solver} reports one, the independent check finds {margin:.2g}"
        case None:
            return ""


def virgin_words(bounds: VirginBounds) -> str:
    """When a step leaves the virgin curve at the earliest, or what keeps it there."""
    s = bounds.stuck
    if s is None:
        return f"not before {1000 * bounds.earliest:.3g} ms, for any rate from k_slow to k_fast"
    return (
        f"the command reaches at most {s.furthest:.4g} kPa {'above' if s.up else 'below'} rest; the line is "
        f"met at {s.threshold:.4g} kPa"
    )


def cycle_words(c: LimitCycle) -> str:
    """Whether a predicted limit cycle is stable, and what the simulation shows."""
    beyond = "; beyond the command range, which the prediction ignores" if c.clipped else ""
    there = "no such cycle"
    if c.seen_amplitude_deg is not None:
        there = (
            f"{c.seen_amplitude_deg:.3g} deg, {c.seen_amplitude_kPa:.3g} kPa at "
            f"{c.seen_frequency_rad_s:.3g} rad/s"
        )
    if c.confirmed:
        seen = f"confirmed: {there}"
    elif c.seen_amplitude_deg is None:
        seen = f"refuted: the simulated loop has {there}"
    else:
        seen = f"refuted: the simulated loop has one of {there} instead"
    return f"{'stable' if c.stable else 'unstable'}{beyond}; {seen}"
