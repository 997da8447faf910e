"""Captions of the robust page's figures, and the sentences that stand beside its tables."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from design.comparison.behind_dead_time import DeadTimeSweep
from design.robustness.assess import Assessment
from design.robustness.certificates.statements import (
    LeavesVirginCurve,
    StaysInRange,
    TasksDieAway,
    Unclipped,
)
from design.robustness.samples.statements import LEVEL
from reports.robustness.claims import claim_words, class_words
from reports.robustness.reasons import because
from reports.robustness.tables import limit_words
from reports.robustness.words import beyond, margin
from reports.shared.figures.dead_time_figure import SETTLED, kept_up_to
from reports.shared.tables import number, spaced


def plane_caption(a: Assessment) -> str:
    """Which certificates these gains have, and what the plane shows."""
    switching = [c for c in a.ladder if not c.remembers]
    held = [c.rung for c in switching if c.holds]
    said = f"certified by {', '.join(dict.fromkeys(held))}" if held else "not certified"
    return (
        f"Star: these gains, {said} for arbitrarily switching slopes. Below the lines the limits are met. "
        "Cross-hatched: unstable on some branch. Filled: certified for such slopes by the certificate named; "
        "for a fixed regulator law the region is larger. Ms and delay margin: linear loops; overshoot: worst "
        "simulated tuning scenario. Edges are interpolated between grid points."
    )


def signature_caption(a: Assessment) -> str:
    """What the small multiples show, with the worst Ms of these gains."""
    limit = a.limits.Ms
    said = ""
    if a.stable:
        beside = "" if limit is None else f" (limit: {number(limit)})"
        said = f" Ms of these gains: at most {number(margin(a, 'Ms'))}{beside}."
    disc = "" if limit is None else "; disc: Ms beyond its limit"
    bent = any(", slope " in str(m["branch"]) or " x " in str(m["rate"]) for m in a.margins)
    worst = ", of each the slope and rate of the largest Ms" if bent else ""
    return (
        f"These gains beside SIMC's.{said} Columns above: branches of the hysteresis at both regulator rates"
        f"{worst}{disc}; third row: the step of the linear loop. Below: the simulated step from each initial "
        "hysteresis state, which passes through several branches."
    )


def late_caption(a: Assessment, sweep: DeadTimeSweep, names: Sequence[str]) -> str:
    """Up to which dead time the overshoot is within its limit."""
    kept = [kept_up_to(sweep, n, a.limits.overshoot_percent) for n in names if n in sweep.overshoot]
    said = f"Overshoot: {'; '.join(kept)}. " if any(kept) else ""
    over = "Worst over both signs and all initial states against added dead time, nominal plant."
    return f"{said}{over} {SETTLED}"


def nyquist_caption(a: Assessment) -> str:
    """On which branch the loop comes nearest to −1."""
    near = _worst_of(a, "Ms", max)
    said = f"Nearest to −1 on {near}, Ms {number(margin(a, 'Ms'))}. " if near else ""
    return (
        f"{said}Nyquist curves of the open loop on all branches and rates. Grey disc about −1: Ms above 2. "
        "Branches differ in slope alone, so at one rate their curves are scaled copies of each other."
    )


def bode_caption(a: Assessment) -> str:
    """The smallest phase margin."""
    where = _worst_of(a, "phase_margin_deg", min)
    least = min(float(m["phase_margin_deg"]) for m in a.margins)
    said = f"Smallest phase margin: {number(least)} deg on {where}. " if where else ""
    return (
        f"{said}Bode plot of the open loop on all branches and rates. Dots: gain crossover; the phase there "
        "above −180 deg is the phase margin."
    )


def sensitivities_caption(a: Assessment) -> str:
    """The peaks of both."""
    said = f"Peaks: |S| {number(margin(a, 'Ms'))}, |T| {number(margin(a, 'Mt'))}. " if a.stable else ""
    return (
        f"{said}Sensitivity |S| (disturbance to angle error) and complementary sensitivity |T| (noise to "
        "angle) on every branch and rate. Dashed: limits."
    )


def _worst_of(a: Assessment, name: str, worst: Callable[..., Mapping[str, Any]]) -> str:
    """The branch and the rate of the regulator where a margin is the worst; empty of an unstable loop."""
    if not a.stable:
        return ""
    m = worst(a.margins, key=lambda m: float(m[name]))
    return f"{spaced(m['branch'])} at the {m['rate']} rate"


def describing_caption(a: Assessment) -> str:
    """Whether a limit cycle is predicted."""
    said = "A limit cycle is predicted." if a.cycles else "No limit cycle is predicted."
    return (
        f"{said} Harmonic balance: one is where a coloured curve, the linear part of the loop, crosses the "
        "black one, −1/N(A) of the hysteresis at pressure amplitude A."
    )


NO_CYCLES = "The table of statements has the result of simulations from large amplitudes."


def envelope_caption(a: Assessment) -> str:
    """The largest overshoot of the cases."""
    over = np.asarray(a.cases.metrics.overshoot_percent, float)[~a.cases.out_of_reach]
    said = f"Largest overshoot of {over.size} cases: {number(float(over.max()))} %. " if over.size else ""
    return (
        f"{said}True angle, both signs drawn upwards: median and band of 90 % of the cases. Below: detail "
        "near the reference; dotted: settling band."
    )


def model_words(a: Assessment) -> str:
    """What the certificates are about."""
    words = (
        "While the command is not clipped the loop has three states (error, static angle less angle, "
        "commanded less actual "
        "pressure), is linear in the slope of the branch, and has no offsets; the certificates below "
        "prove exponential stability of these states for every sequence of branches. The virgin curve, of "
        "slope 0, is left once and never entered again; the time on it is bounded separately."
    )
    model = a.left_out
    if model:
        words += f" The plant also has {', '.join(model)}, which the certificates do not include."
    return words


def claims(a: Assessment) -> list[str]:
    """What each certificate claims, those of the sampled loop together; and what disproves some."""
    found: dict[str, list[str]] = {}
    for c in a.ladder:
        if not c.dead_time:
            about = "" if c.about is None else class_words(c.about)
            found.setdefault(about, []).append(c.rung)
    said = [f"{_start(', '.join(rungs))}: {claim}." for claim, rungs in found.items()]
    if a.word is not None:
        said.append(
            f"Where the rate switches too, a destabilising switching sequence exists: "
            f"{spaced(str(a.word))}. It belongs "
            "to the class, not to the wrist, whose rate follows the pressure error."
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
        f"{len(cases)} cases, independent: a plant from the box below, one of four initial "
        "hysteresis states, either sign of the step"
    ]
    parts += [f"dead time up to {1000 * c.dead_time:.3g} ms"] if c.dead_time else []
    parts += [f"a constant load of up to ±{c.load:g} deg"] if c.load else []
    parts += [f"sensor noise of {c.noise:g} deg (s.d.) at 100 Hz"] if c.noise else []
    parts += [f"a sensor resolution of {c.quantum:g} deg"] if c.quantum else []
    words = ", ".join(parts) + ". A statement is met where the whole interval is below "
    words += f"{100 * LEVEL:g} % of cases, and is open where the interval contains that figure."
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
        f"References in turn: {spaced(w.case.name)}. {what} Found in "
        f"{w.evaluations} runs by differential evolution and Nelder-Mead over the box, the initial "
        "hysteresis "
        "state, three references and how long each is held. This is a lower bound of the true worst case."
    )


def worst_caption(a: Assessment) -> str:
    """Beneath the worst scenario."""
    m = a.worst.metrics
    return (
        "The worst scenario found, simulated exactly. The last step, shaded, is judged: "
        f"overshoot {number(m['overshoot_percent'], 2)} %, error at the end "
        f"{number(m['steady_state_error_deg'], 2)} deg, total variation of the command "
        f"{number(m['total_variation_V'], 3)} V."
    )


def assumptions(a: Assessment) -> list[str]:
    """What stands beside parameters."""
    low, high = a.wrist.rig.command_range
    found = [
        f"Limits: {limit_words(a.limits)}.",
        f"The command is clipped at {low:g} and {high:g} V; certificates hold where it is not.",
        "Estimates with correlated errors vary together; certificates vary each of them by itself."
        if a.box.plant.correlation
        else "The box ignores correlations between fitted parameters.",
        "Dead time, load, noise and resolution of the samples are assumed; their magnitudes are typical.",
    ]
    return found
