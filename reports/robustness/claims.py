"""What statements claim, in words."""

from design.robustness.certificates.certificate import LoopClass, Switching
from design.robustness.certificates.constant.robust_stability import (
    StableWhileConstant,
)
from design.robustness.certificates.statements import (
    ClassDiesAway,
    DiesAway,
    LeavesVirginCurve,
    StaysInRange,
    TasksDieAway,
)
from design.robustness.predictions.limit_cycles import (
    HasCycle,
    NoOscillation,
)
from design.robustness.predictions.margins import MarginHeld, StableEverywhere
from design.robustness.samples.statements import RarelyBroken
from design.robustness.statement import Claim

MARGINS = {
    "Ms": "Ms", "delay_margin_s": "delay margin", "gain_margin": "gain margin",
    "phase_margin_deg": "phase margin", "Mt": "Mt", "disk_margin": "disk margin",
    "WT": "|W T| of the residual as unmodelled dynamics",
}  # fmt: skip


CLASSES = {
    Switching.MEMORY: "sampled loop: decays while at most one line of the hysteresis is met",
    Switching.MEMORY_IN_BOX: "sampled loop: decays while at most one line is met, on every plant of the box",
    Switching.SLOPE_EVERY_SAMPLE: "decays under arbitrary switching of the slope at every sample",
    Switching.FIXED_LAW: "decays under arbitrary switching of the slope, with a fixed regulator law",
    Switching.ANY_TIME: "decays under arbitrary switching of slope and regulator rate",
    Switching.EVERY_SAMPLE: "decays under arbitrary switching of slope and regulator rate at every sample",
}


def late(dead_time: float) -> str:
    """A dead time [s] in words; empty where there is none."""
    return f", {1000 * dead_time:.3g} ms of dead time" if dead_time else ""


def claim_words(claim: Claim) -> str:
    """What is claimed.

    >>> claim_words(StaysInRange(15.0, 0.05))
    'a step of 15 deg from a line never clips the command, 50 ms of dead time'
    """
    match claim:
        case DiesAway(rung, about, dead_time):
            return f"{rung}{late(dead_time)}: {'' if about is None else class_words(about)}"
        case ClassDiesAway(switching, dead_time):
            return CLASSES[switching] + late(dead_time)
        case StaysInRange(step, dead_time):
            return f"a step of {step:g} deg from a line never clips the command{late(dead_time)}"
        case TasksDieAway(step, dead_time):
            return (
                f"steps of {step:g} deg of both signs from every initial state, and returns: exponentially "
                f"stable with this rate, sampled loop with command range{late(dead_time)}"
            )
        case LeavesVirginCurve(step):
            return f"a step of {step:+g} deg from rest leaves the virgin curve by this time"
        case StableWhileConstant(gain, dead_time, dynamics):
            parameters = "slope, rate, Tw and gain" if gain else "slope, rate and Tw"
            behind = f", with up to {1e3 * dead_time:.3g} ms of dead time" if dead_time > 0.0 else ""
            left = " and the residual as unmodelled dynamics" if dynamics else ""
            return f"stable for every constant {parameters} within the box{behind}{left}"
        case StableEverywhere():
            return "the linear loop is stable on every branch at every rate"
        case MarginHeld(key, at_most, limit):
            if limit is None:
                return f"{MARGINS[key]} on every branch"
            shown = f"{1e3 * limit:.3g} ms" if key == "delay_margin_s" else f"{limit:g}"
            return f"{MARGINS[key]} {'at most' if at_most else 'at least'} {shown} on every branch"
        case NoOscillation():
            return "no sustained oscillation about the reference"
        case HasCycle(c):
            return (
                f"{'a stable' if c.stable else 'an unstable'} limit cycle: {c.amplitude_deg:.3g} deg, "
                f"{c.amplitude_kPa:.3g} kPa at {c.frequency_rad_s:.3g} rad/s"
            )
        case RarelyBroken(words, level):
            return f"{words} in at most {100 * level:g} % of cases"
    raise TypeError(f"no words for {claim!r}")


def class_words(c: LoopClass) -> str:
    """What is claimed of a class of loops."""
    if c.switching is Switching.EVERY_SAMPLE:
        behind = f" behind {c.samples} samples of dead time" if c.samples else ""
        return (
            f"the sampled loop{behind}, slope and regulator rate switching arbitrarily at every sample, "
            "decays while the command is not clipped"
        )
    (low, high), (shallow, steep) = c.rates, c.slopes
    if c.switching.sampled:
        behind = f" behind {c.samples} samples of dead time" if c.samples else ""
        moves = f"slope {shallow:.4g} to {steep:.4g} deg/kPa switching arbitrarily at every sample"
        if c.switching is not Switching.SLOPE_EVERY_SAMPLE:
            moves = (
                f"slope {shallow:.4g} to {steep:.4g} deg/kPa as the hysteresis sets it, of which at most one "
                "line is met"
            )
        if c.lag is not None:
            moves += f", Tw from {c.lag[0]:.4g} to {c.lag[1]:.4g} s, varying in the same way"
        return (
            f"the sampled loop{behind}, the regulator's law fixed, k from {low:.4g} to {high:.4g} 1/s, "
            f"{moves}, decays while the command is not clipped"
        )
    among = f"slope {shallow:.4g} to {steep:.4g} deg/kPa changing at any time"
    if c.switching is Switching.ANY_TIME:
        return f"decays for a regulator rate {low:.4g} to {high:.4g} 1/s and a {among}"
    law = "growing with q" if c.monotone else "without memory"
    return (
        f"decays for every fixed law k(q) q of the regulator, k from {low:.4g} to {high:.4g} 1/s and "
        f"k(q) q - {low:.4g} q {law}, and {among}"
    )
