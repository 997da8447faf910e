"""The tuning stage of a design: every controller that is offered, each under the same requirement.

A PI, one with two degrees of freedom, a feedforward around the loop of one of these, a cascade with the
measured pressure inside, an LQI, and an MPC where it is asked for; where the plant leaves a residual also the
PI of a plant that leaves none; where neither PI holds, the part of the requirement that would have to go.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from design.alternatives.designs import LQI_NAME, ROBUST_MPC
from design.evaluation.cases import Case
from design.mpc.margins_at_rest import margins_at_rest
from design.robustness.box import Box
from design.robustness.checks import worst_found
from design.robustness.requirement import Requirement
from design.robustness.samples.worst import excesses as of_samples
from design.robustness.tuning.recommended import PLAIN, TWO_DOF, tune_candidates
from design.robustness.tuning.robust_lqi import tune_lqi
from design.robustness.tuning.robust_mpc import EFFORT as MPC_EFFORT
from design.robustness.tuning.robust_mpc import tune_mpc
from design.robustness.tuning.robust_tuning import RobustTuning, tune_robustly
from design.synthesis.answer import LimitBroken, OutOfReach
from design.synthesis.convex import Unsolved
from design.synthesis.designed_plant import without
from design.synthesis.requirements import excesses
from design.synthesis.structure import CASCADE_PI, FORWARD_PI, forward_pi
from design.synthesis.tuning import Region, Tuning
from plants.effects.effect import dead_time_of
from plants.errors import InputError

Tell = Callable[[str, float], None]

FORWARD, CASCADE = FORWARD_PI.name, CASCADE_PI.name
BARE = "PI, residual left out"
"""What a PI would be whose plant left nothing: told beside, to show what the residual costs."""

RESIDUAL = "the plant's residual"
"""What would have to go where that one meets every limit."""


COARSE = 12
"""Points of the maps on which it is asked what keeps gains from holding: a tuning goes on from their best."""


@dataclass(frozen=True)
class DesignEffort:
    """How much is spent: fresh samples, runs of the search for the worst case, points of maps, rounds; mpc:
    whether an MPC is tuned too, which takes a quarter of an hour a motion; alternatives: whether a
    feedforward, a cascade and an LQI are, which takes half of the time."""

    samples: int = 20_000
    runs: int = 50_000
    points: int = 40
    rounds: int = 15
    mpc: bool = False
    alternatives: bool = True


def tuned_designs(
    required: Requirement, effort: DesignEffort, seed: int, jobs: int | None, tell: Tell,
    cases: tuple[Case, ...] = (),
) -> dict[str, Any]:  # fmt: skip
    """Records of the controllers by name; `relaxed` says in words what would have to be taken away where
    neither PI holds the requirement, else None.  cases: that are in the set from the beginning."""
    region = Region.of(required.wrist, effort.points)
    both = tune_candidates(required, region, seed, effort.rounds, jobs, lambda s, h: tell(s, 0.6 * h), cases)
    plain = both.plain
    found = {PLAIN: _tuning_record(plain), TWO_DOF: _tuning_record(both.two_dof or plain)}
    if both.two_dof is not None and effort.alternatives:
        loops = [both.best.final] + ([both.plain.final] if both.best is both.two_dof else [])

        def under(name: str, begin: float) -> Tell:
            return lambda stage, share: tell(f"{name}: {stage}", begin + 0.13 * share)

        base = both.best.final
        found |= _forward(required, loops, seed, effort, jobs, under(FORWARD, 0.6))
        found |= _cascade(required, region, base, seed, effort, jobs, under(CASCADE, 0.73))
        found |= _lqi(required, base, seed, effort, jobs, under(LQI_NAME, 0.86))
    if required.box.remainder is not None:
        bare = replace(required, box=required.box.leaving(None))
        tell("without the residual", 0.99)
        found[BARE] = _tuning_record(tune_robustly(bare, region, 0, seed, effort.rounds, jobs))
    holds = any(found[n]["holds"] for n in (PLAIN, TWO_DOF))
    if holds:
        return {**found, "relaxed": None}
    # What is tuned already need not be looked for.
    bare_holds = BARE in found and found[BARE]["holds"]
    gone = RESIDUAL if bare_holds else _would_have_to_go(required, seed, effort.rounds, jobs, tell)
    return {**found, "relaxed": gone}


def _forward(
    required: Requirement,
    loops: list[Tuning],
    seed: int,
    effort: DesignEffort,
    jobs: int | None,
    tell: Tell,
) -> dict[str, dict[str, Any]]:
    """A feedforward around the first of some PI loops with which it holds the requirement, else around the
    first; none for a plant that has no inverse.

    Its worst cases are rare: a model on another branch than the wrist, after a step that was taken back.
    """
    known = dead_time_of(required.wrist.effects)
    structure = forward_pi(known + 0.5 * required.space.dead_time)  # the middle of the interval
    try:
        structure.of(required.wrist, 0.0, 0.0, **structure.settings)
    except (InputError, ValueError):
        return {}
    found: list[dict[str, Any]] = []
    for base in loops:
        tuned = tune_robustly(required, None, 0, seed, effort.rounds, jobs, tell, structure, base)
        found.append(_searched(required, tuned, seed, effort, jobs, tell))
        if found[-1]["holds"]:
            return {FORWARD: found[-1]}
    return {FORWARD: found[0]}


def _cascade(
    required: Requirement,
    region: Region,
    base: Tuning,
    seed: int,
    effort: DesignEffort,
    jobs: int | None,
    tell: Tell,
) -> dict[str, dict[str, Any]]:
    """A cascade with the measured pressure inside under the same requirement, from the cases of a PI; none
    where no inner loop is the best, which is a PI once more."""
    tuned = tune_robustly(required, region, 0, seed, effort.rounds, jobs, tell, CASCADE_PI, base)
    if not tuned.final.gains["Kc"]:
        return {}
    return {CASCADE: _searched(required, tuned, seed, effort, jobs, tell)}


def _lqi(
    required: Requirement, base: Tuning, seed: int, effort: DesignEffort, jobs: int | None, tell: Tell
) -> dict[str, dict[str, Any]]:
    """An LQI under the same requirement, from the cases of a PI; none for a plant without such a feedback."""
    try:
        tuned = tune_lqi(required, base, seed, effort.rounds, jobs, tell)
    except (Unsolved, InputError, ValueError):
        return {}
    return {LQI_NAME: _searched(required, tuned, seed, effort, jobs, tell)}


def mpc_design(
    required: Requirement, seed: int, rounds: int, jobs: int | None, tell: Tell
) -> dict[str, dict[str, Any]]:
    """An MPC under the same requirement, whose margins at rest are judged on every corner of the box; none
    where its solver is not installed, or where the plant has none."""
    try:
        tuned = tune_mpc(required, seed, rounds, jobs, lambda s, h: tell(f"{ROBUST_MPC}: {s}", h))
    except InputError:
        return {}
    found = _tuning_record(tuned)
    late = (0.0, required.space.dead_time)
    tell(f"{ROBUST_MPC}: margins", 0.99)
    margins = _at_rest(required, tuned.final.controller, late)
    named = {n: v for n, v in required.limits.named.items() if n in margins}
    linear = excesses({n: np.array([margins[n]]) for n in named}, named)
    beyond = _beyond(required, tuned) | {n: float(e[0]) for n, e in linear.items()}
    worst = max((e, n) for n, e in beyond.items())
    holds = found["holds"] and all(e[0] <= 0.0 for e in linear.values())
    fresh = 0 if tuned.fresh is None else int(tuned.fresh.excess.size)
    checked = {"samples": fresh, "search_runs": MPC_EFFORT.search if fresh else 0}
    told = {**found, **checked, "holds": holds, "margins": margins}
    return {ROBUST_MPC: {**told, "worst_excess": worst[0], "worst_excess_of": worst[1]}}


def _at_rest(required: Requirement, controller: Any, late: tuple[float, float]) -> dict[str, float]:
    """Margins of an MPC at rest on every corner of the box, WT on the nominal plant, which leaves it."""
    found = dict(vars(margins_at_rest(controller, required.corners(), late)))
    weight = required.box.weight
    if weight is not None:
        found["WT"] = margins_at_rest(controller, [required.wrist], late, weight).WT
    return {n: v for n, v in found.items() if v is not None}


def _beyond(required: Requirement, tuned: RobustTuning[Any]) -> dict[str, float]:
    """By what share gains lie beyond each limit, no guard counted, in the cases of their tuning; of those
    that were simulated."""
    of = excesses(tuned.final.at.values, {
        n: v for n, v in required.limits.named.items() if n in tuned.final.at.values})  # fmt: skip
    return {n: float(e[0]) for n, e in of.items() if not np.isnan(e[0])}


def _searched(
    required: Requirement,
    tuned: RobustTuning[Any],
    seed: int,
    effort: DesignEffort,
    jobs: int | None,
    tell: Tell,
) -> dict[str, Any]:
    """The record of an alternative to a PI, which holds only what one search more does not break, in half as
    many runs as the recommended gains; of one that does not hold, by how much it breaks the limits, no guard
    counted, in the cases of its tuning, or in fresh samples where only the sensor's noise breaks one."""
    found = _tuning_record(tuned)
    beyond = _beyond(required, tuned)
    if tuned.ended == "noise breaks a limit" and tuned.fresh is not None:
        beyond = {n: float(e.max()) for n, e in of_samples(tuned.fresh.values, required.limits).items()}
    if not tuned.holds and beyond:
        worst_of = max(beyond, key=beyond.__getitem__)
        found |= {"worst_excess": beyond[worst_of], "worst_excess_of": worst_of}
    if tuned.holds:
        tell("search for the worst case", 0.9)
        worst = worst_found(required, tuned.final.controller, effort.runs // 2, seed + 78, jobs)
        found |= {
            "holds": worst.broken == 0, "worst_excess": worst.excess, "worst_excess_of": worst.excess_of,
            "worst_case": worst.case.name,
        }  # fmt: skip
    return found


def _would_have_to_go(
    required: Requirement, seed: int, rounds: int, jobs: int | None, tell: Tell
) -> str | None:
    """The first part of the requirement, or effect of the plant, without which a plain PI holds the rest, in
    words; None where taking away one is not enough.  What leaves out the residual is among the designs."""
    own, plant = required.conditions, required.box.plant
    lesser = {
        "the dead time": replace(required, conditions=replace(own, dead_time=0.0)),
        "the load": replace(required, conditions=replace(own, load=0.0)),
        "steps before the last has settled": replace(required, kinds=("step",)),
        "the box of parameters": replace(required, box=Box(plant, ()).leaving(required.box.remainder)),
    }
    lesser |= {
        f"the plant's {e.NAME}": replace(required, box=_without(required.box, e.NAME))
        for e in plant.effects
        if e.DELAY is None
    }
    for words, less in lesser.items():
        tell(f"without {words}", 0.99)
        if tune_robustly(less, Region.of(less.wrist, COARSE), 0, seed, rounds, jobs).holds:
            return words
    return None


def _without(box: Box, effect: str) -> Box:
    """The box of the same plants without an effect."""
    kept = tuple(i for i in box.intervals if i.name.split(".")[0] != effect)
    return replace(box, plant=without(box.plant, (effect,)), intervals=kept)


def _tuning_record(found: RobustTuning[Any]) -> dict[str, Any]:
    t = found.final
    nearest = None
    if found.ended == "out of reach":
        nearest = {"limit": t.active, "words": OutOfReach.__name__}
    elif not t.feasible:
        nearest = {"limit": t.active, "words": LimitBroken.__name__}
    return {
        "gains": t.gains, "cost": float(t.at.cost[0]), "guard": found.guard,
        "holds": found.holds, "ended": found.ended, "active": t.active, "nearest": nearest,
        "cases": len(t.problem.adverse), "rounds": len(found.rounds),
    }  # fmt: skip
