"""What a design says in sentences: the last line, the summary of the page, captions."""

from collections.abc import Mapping
from math import isfinite
from typing import Any

from design.robustness.certificates.memory.ladder import IN_BOX
from design.robustness.samples.worst import ASIDE
from design.robustness.tuning.recommended import PLAIN
from design.studies.design_study import DesignStudy, MotionDesign
from design.studies.designs import BARE
from design.synthesis.answer import OutOfReach
from plants.effects.wrist.remainder import STEEPNESS
from plants.parameters.remainder import UncertaintyWeight
from plants.wrist import Wrist
from reports.shared.card import broken_words, gains_words
from reports.shared.dynamics import dynamics_words
from reports.shared.names import limit_in_text
from reports.shared.tables import listed, number

WHOLE = ("worst case found", "proved")
"""Guarantees of the whole requirement; the others are of less."""

OTHER_MOTION = "other_pressure_kPa"
"""The column of a log that an effect of the other motion needs."""


def title(study: DesignStudy) -> str:
    """The heading: what is recommended, or that nothing is; the gains stand in the card."""
    found: dict[str, list[str]] = {}
    for m in study.motions:
        found.setdefault(m.recommended, []).append(m.motion)
    words = listed([f"{name} for {listed(motions)}" for name, motions in found.items()])
    return f"Recommended: {words}" if study.holds else f"No gains meet every limit; the nearest: {words}"


def controllers(study: DesignStudy) -> str:
    """The title of the table of gains."""
    return "Recommended controllers." if study.holds else "Nearest controllers; a limit is broken."


def summary(study: DesignStudy) -> list[str]:
    """Three sentences, of at most 20 words each: what holds, under what, what is proved."""
    samples = sum(m.evidence["samples"]["total"] for m in study.motions)
    runs = sum(m.evidence["worst_case"]["runs"] for m in study.motions)
    broken = sum(m.evidence[n]["broken"] for m in study.motions for n in ("samples", "worst_case"))
    if study.holds:
        first = f"These gains meet every limit in {samples} fresh samples and in {runs} runs of a search."
    else:
        first = (
            f"No gains found meet every limit: the nearest break one in {broken} of {samples + runs} runs."
        )
    late = max(r["longest_dead_time_s"] for r in study.requirements.values())
    second = (
        f"Covered: dead time up to {number(1000 * late)} ms, every initial state, load, noise and plant of "
        "the box."
        if late
        else "Covered: every initial state, load, noise and plant of the box; no dead time."
    )
    proved = [m.motion for m in study.motions if m.evidence["proved"]["status"] == "proved"]
    still = [m.motion for m in study.motions if m.motion not in proved]
    third = (
        f"A proof of stability for the sampled loop with that dead time is open for {listed(still)}."
        if still
        else "On the plant as fitted, the sampled loop with that dead time is proved exponentially stable."
    )
    return [first, second, third]


def worse_words(trace: Mapping[str, Any]) -> str:
    """That a revised plant is further off the angle on held-out recordings than the declared one; empty where
    it is not."""
    before, after = (trace.get(name, {}).get("angle_deg") for name in ("before", "after"))
    if before is None or after is None or after <= 1.0001 * before:
        return ""
    return f", above {number(before)} deg of the declared plant: tune that one (`wrist fit`, `wrist tune`)"


def motion_lines(m: MotionDesign) -> list[str]:
    """What people read of a motion on the command line."""
    samples, worst, proved = (m.evidence[n] for n in ("samples", "worst_case", "proved"))
    found = [f"{m.motion}: {m.recommended}, {gains_words(m.gains)}"]
    after = m.trace["after"].get("angle_deg")
    names = listed([e["name"] for e in m.trace["effects"]]) if m.trace["effects"] else "nothing"
    error = f"held-out error {number(after)} deg{worse_words(m.trace)}"
    found.append(f"  trace: {m.trace['verdict']}, adds {names}; {error}")
    if counted := m.plant.rig.zero.words(m.plant.rig.units):
        found.append(f"  counted: {counted} of the log")
    if m.left_out:
        found.append(f"  left out of the design: {listed(list(m.left_out))}")
    rig = m.plant.rig
    steps = f"steps of {number(rig.task.step)} {rig.units.angle}"
    found.append(f"  loop: sample time {number(1000 * rig.sample_time)} ms, {steps} either way")
    if m.guessed:
        found.append(
            f"  task and limits were guessed from the log ({steps}, "
            f"settling within {number(rig.limits['settling_time_s'])} s): set them in [rig.task] and "
            f"[rig.limits] of a copy of plant-{m.motion}.toml, and give that with --plant"
        )
    found.append(
        f"  {samples['broken']} of {samples['total']} fresh samples break a limit (below "
        f"{number(100 * samples['upper_bound'], 2)} % at 95 % confidence)"
    )
    excess = worst["excess"]
    by = (
        f"{number(100 * abs(excess), 2)} % " if excess < ASIDE else ""
    )  # what never settles is beyond by none
    found.append(
        f"  {worst['broken']} of {worst['runs']} runs of the search break a limit; worst case: "
        f"{limit_in_text(worst['excess_of'])} {by}{'beyond' if excess > 0.0 else 'below'} its limit in "
        f"{worst['scenario']}"
    )
    iae = max(e["worst_iae_deg_s"] for e in (samples, worst))
    slowest = samples["worst_settling_s"]
    settles = (
        "a sample does not settle"
        if slowest is None or not isfinite(slowest)
        else f"slowest settling {number(slowest)} s in samples"
    )
    found.append(f"  steps of the task: worst IAE {number(iae)} deg s in samples and search, {settles}")
    found.append(
        f"  exponential stability of the sampled loop, with the longest dead time: {proved['status']}"
    )
    return found


def last_line(study: DesignStudy) -> str:
    """The gains, what they hold, what is open."""
    gains = "; ".join(f"{m.motion} {gains_words(m.gains)}" for m in study.motions)
    if not study.holds:
        beyond = [m.motion for m in study.motions if _out_of_reach(m)]
        if beyond:
            return (
                f"no gains meet every limit: no command in its range holds the steps of {listed(beyond)}; "
                "give a plant with other steps, in its table [rig.task], with --plant"
            )
        gone = sorted({m.relaxed for m in study.motions if m.relaxed and not m.holds})
        without = f"; every limit would be met without {listed(gone)}" if gone else ""
        why = "".join(f"; {m.motion}: {w}" for m in study.motions if not m.holds for w in hindered(m))
        return f"no gains meet every limit; nearest: {gains}{without}{why}"
    late = max(r["longest_dead_time_s"] for r in study.requirements.values())
    held = f"meet every limit with up to {number(1000 * late)} ms of dead time"
    still = [m.motion for m in study.motions if m.evidence["proved"]["status"] != "proved"]
    proved = "exponential stability is proved on the plant as fitted"
    open_ = f"a proof of stability is open for {listed(still)}" if still else proved
    return f"{gains}: {held} in all samples and search runs; {open_}"


def _out_of_reach(m: MotionDesign) -> bool:
    """Whether the steps of the task, and not the gains, are what fails."""
    nearest = m.designs[m.recommended].get("nearest")
    return nearest is not None and nearest["words"] == OutOfReach.__name__


def hindered(m: MotionDesign) -> list[str]:
    """Why no gains hold the angle of a motion in the band of its task, of each effect that keeps it out."""
    task, unit = m.plant.rig.task, m.plant.rig.units.angle
    found = (e.hinders(task.band * task.step, unit) for e in Wrist.of(m.plant).effects)
    return [words for words in found if words is not None]


def remarks(study: DesignStudy) -> list[str]:
    """What a reader has to know besides the summary."""
    share = 100 * study.guard["overshoot_percent"]
    found = [
        f"The tuning keeps the overshoot {number(share)} % below its limit, since it changes abruptly "
        "between "
        "cases; the verdict uses the limit itself. A search that finds no broken limit proves nothing."
    ]
    found += [
        f"{m.motion}: no gains meet the limits with that reserve; these keep "
        f"{number(100 * m.guard['overshoot_percent'])} %, so a small change of the plant may break a limit."
        for m in study.motions
        if m.holds and m.guard["overshoot_percent"] < study.guard["overshoot_percent"]
    ]
    found += [words for words in map(weight_words, study.motions) if words]
    found += [
        f"{m.motion}: this page counts {counted} of the log. The exported C has functions that convert "
        f"{'what is measured and the reference' if zero.angle or zero.reversed else 'the measured pressure'}."
        for m in study.motions
        if (zero := m.plant.rig.zero)
        if (counted := m.plant.rig.zero.words(m.plant.rig.units))
    ]
    found += [
        f"{m.motion}: {why}. Give a wider band, in [rig.task], with --plant, or less friction."
        for m in study.motions
        if not m.holds
        for why in hindered(m)
    ]
    found += [
        f"{m.motion}: the other motion moves this angle. The design keeps the other motion at rest: while it "
        "moves, the overshoot may exceed its limit and settling takes longer."
        for m in study.motions
        if any(OTHER_MOTION in effect.LOG for effect in m.plant.effects)
    ]
    left = [remainder_words(m, study.requirements[m.motion]["remainder"]) for m in study.motions]
    found += [words for words in left if words]
    found += [
        f"{m.motion}: the design leaves out {listed(list(m.left_out))}, in the sensor or an event of the "
        "recordings."
        for m in study.motions
        if m.left_out
    ]
    return found


def remainder_words(m: MotionDesign, left: Mapping[str, Any] | None) -> str:
    """What the residual of a motion's plant costs; empty where it is within the noise."""
    if left is None:
        return ""
    size = f"up to {number(left['peak'])} deg along {number(left['length'])} deg of travel"
    bare, plain = m.designs.get(BARE), m.designs[PLAIN]
    words = f"{m.motion}: the unexplained residual of the plant ({size}) acts as a disturbance in every case."
    words += _slopes_words(m, 100 * STEEPNESS * left["peak"] / left["length"])
    if "weight" in left:
        words += f" {dynamics_words(UncertaintyWeight(**left['weight']))}"
    if bare is None or not (bare["holds"] and plain["holds"]):
        return words
    return (
        f"{words} Without it the PI would be {gains_words(bare['gains'])}; with it the worst IAE is "
        f"{number(100 * (plain['cost'] / bare['cost'] - 1), 2)} % higher."
    )


def _slopes_words(m: MotionDesign, percent: float) -> str:
    """What is proved where the residual changes the slopes by up to so many percent."""
    proved = m.evidence["proved"]
    found = [
        r
        for r in proved.get("rungs", ())
        if IN_BOX in r["rung"] and r["dead_time_s"] == proved["dead_time_s"]
    ]
    if not found:
        return ""
    rate = None if proved.get("left_out") else found[0]["rate_1_s"]
    words = "a proof of stability is open" if rate is None else (
        f"exponentially stable with rate at least {number(rate, 2)} 1/s while at most one line is met"
    )  # fmt: skip
    return f" It changes slopes by up to {number(percent, 2)} %; on the plants of that box: {words}."


def _dearer(study: DesignStudy) -> str:
    """What the whole requirement costs beside gains tuned for branches and starts alone."""
    said = []
    for m in study.motions:
        of = {(r["guarantee"], r["controller"]): r["worst_iae_deg_s"] for r in m.prices}
        before, after = of.get(("memory and corners", PLAIN)), of.get(("worst case found", m.recommended))
        if before and after and all(map(isfinite, (before, after))):
            share = 100 * (after / before - 1.0)
            said.append(f"{number(abs(share), 2)} % {'more' if share > 0.0 else 'less'} on {m.motion}")
    if not said:
        return ""
    gains = "recommended" if study.holds else "nearest"
    return f"The {gains} gains err {listed(said)} than gains tuned for branches and starts only. "


def price_caption(study: DesignStudy) -> str:
    """Beneath the prices."""
    held = any(r["guarantee"] in WHOLE and r["feasible"] for m in study.motions for r in m.prices)
    blue = "Blue: tuned for the whole requirement, no broken limit found; " if held else ""
    return (
        f"{_dearer(study)}Worst IAE over the same steps for every bar: all plants of the box, initial "
        f"states, loads and dead times. {blue}▲: limit broken. Gains tuned for weaker "
        "guarantees may be faster here, but break limits in other cases."
    )


def controller_words(m: MotionDesign) -> str:
    """What is known of a recommended controller: how often it was seen to break a limit."""
    samples, worst = m.evidence["samples"], m.evidence["worst_case"]
    return broken_words(samples["broken"] + worst["broken"], samples["total"] + worst["runs"])


def weight_words(m: MotionDesign) -> str:
    """What a reference weight gains; nothing where it is not recommended, or where the plain PI fails."""
    plain, best = m.designs[PLAIN], m.designs[m.recommended]
    if m.recommended == PLAIN or not (plain["holds"] and best["holds"]):
        return ""
    share = number(100 * (1 - best["cost"] / plain["cost"]), 2)
    return f"{m.motion}: the reference weight lowers the worst IAE by {share} %."
