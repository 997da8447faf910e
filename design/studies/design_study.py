"""The whole way from campaigns to recommended controllers, as one value: what was found, and what is open.

Per motion: trace the campaign, tune on the revised plant under the rig's whole requirement a PI and one
with two degrees of freedom, recommend one, check it on fresh samples, search for its worst case, ask for
proofs of exactly its gains, and price each guarantee.  Whoever shows a study (the command, a page) takes the
value and computes nothing.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from threading import Lock
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from design.cluster import each
from design.controllers.pi import PI
from design.robustness.box import Box
from design.robustness.requirement import Requirement, requirement, requirement_record
from design.robustness.tuning.robust_tuning import GUARD
from design.studies.confirmed import best_of, confirmed
from design.studies.designs import DesignEffort, mpc_design, tuned_designs
from design.studies.proof import kept_proof
from design.studies.shown.limits_matrix import matrix, step_band
from design.studies.shown.prices import price_rows, proved_row
from design.studies.stages import Stages
from design.synthesis.designed_plant import designed, left_out
from design.synthesis.structure import with_gains
from plants.kernel.batches import default_jobs
from plants.measured.campaigns.campaign import Campaign
from plants.measured.trace.trace import trace_for_design
from plants.parameters.files import dump, load
from plants.parameters.quantities import ParameterSet
from plants.rig import built_in_rig
from plants.wrist import Wrist

Array = NDArray[np.float64]
Tell = Callable[[str, float], None]

STAGES = ("trace", "tune", "check", "prices", "page")
"""Stages of a motion, in order; shares of the time that each takes.  The proof goes on beside two of them."""

SHARES = (0.12, 0.66, 0.10, 0.10, 0.02)


@dataclass(frozen=True)
class Taken:
    """Parts that are taken away from what the rig states: no dead time, no load, no noise, no box; and what
    the plant leaves."""

    dead_time: bool = False
    load: bool = False
    noise: bool = False
    box: bool = False
    remainder: bool = False

    @property
    def names(self) -> tuple[str, ...]:
        """The parts by name."""
        return tuple(n for n, gone in vars(self).items() if gone)


@dataclass(frozen=True)
class MotionDesign:
    """What was found of a motion: the revised plant, what of it the loop was designed without, and the
    records of the stages, of dictionaries, lists, numbers and text.

    designs: of each controller its gains and tuning; recommended: which of them; evidence: fresh samples,
    worst case, proof; prices: rows; matrix: limits by what they hold under; band: the steps that are drawn;
    guessed: whether the rig was guessed from its log, with its task and its limits.
    """

    motion: str
    plant: ParameterSet
    left_out: tuple[str, ...]
    trace: Mapping[str, Any]
    designs: Mapping[str, Mapping[str, Any]]
    recommended: str
    evidence: Mapping[str, Any]
    prices: tuple[Mapping[str, Any], ...]
    matrix: tuple[Mapping[str, Any], ...]
    band: Mapping[str, Any]
    relaxed: str | None
    guessed: bool = False

    @property
    def gains(self) -> dict[str, float]:
        """The recommended gains: Kp [kPa/deg], Ki [kPa/(deg s)], b [1], Tf [s]."""
        return dict(self.designs[self.recommended]["gains"])

    @property
    def guard(self) -> dict[str, float]:
        """Shares of the limits that the gains were tuned below them by."""
        return dict(self.designs[self.recommended]["guard"])

    @property
    def controller(self) -> PI:
        """The recommended controller."""
        return cast(PI, with_gains(Wrist.of(self.plant), self.gains))

    @property
    def holds(self) -> bool:
        """Whether tuning, fresh samples and the search for the worst case found no broken limit."""
        samples, worst = self.evidence["samples"], self.evidence["worst_case"]
        return bool(self.designs[self.recommended]["holds"]) and not samples["broken"] and not worst["broken"]

    @property
    def limits_broken(self) -> tuple[str, ...]:
        """The limits that the gains break under any condition, by name; none where they hold, or where the
        search alone tells that one is broken and not which."""
        if self.holds:
            return ()
        found = [row["limit"] for row in self.matrix if False in row["held"].values()]
        worst = self.evidence["worst_case"]
        of_search = [worst["excess_of"]] if worst["broken"] and "excess_of" in worst else []
        return tuple(dict.fromkeys([*found, *of_search]))


@dataclass(frozen=True)
class DesignStudy:
    """What was found of every motion, under which requirement, tuned by which guard."""

    motions: tuple[MotionDesign, ...]
    requirements: Mapping[str, Mapping[str, Any]]
    guard: Mapping[str, float]
    effort: DesignEffort

    @property
    def holds(self) -> bool:
        """Whether every motion's gains hold what is required."""
        return all(m.holds for m in self.motions)


def design_study(
    campaigns: Mapping[str, tuple[Campaign, ParameterSet | None]],
    folder: Path,
    effort: DesignEffort | None = None,
    taken: Taken | None = None,
    seed: int = 0,
    jobs: int | None = None,
    progress: Tell | None = None,
) -> DesignStudy:
    """Design for campaigns, each with the set that its fit starts from, if one was given; stages are kept
    in `folder`/stages, and the revised plants as plant-MOTION.toml in `folder`.

    jobs: threads, all processors where None.  Motions do not depend on each other and go on side by side:
    while one searches in Python, another's simulations have the processors.

    Raises InputError as trace and box do.
    """
    effort, taken = effort or DesignEffort(), taken or Taken()
    stages = Stages(folder / "stages")
    tells = _together(list(campaigns), progress)

    def of_motion(motion: str) -> tuple[MotionDesign, dict[str, Any]]:
        data, start = campaigns[motion]
        plant, traced = _traced(motion, data, start, folder, stages, seed, tells[motion])
        required = required_of(designed(plant), taken)
        done = _designed(motion, plant, traced, required, stages, effort, seed, jobs, tells[motion])
        done = replace(done, guessed=start is None and motion not in built_in_rig().motions)
        return done, requirement_record(required)

    found = each(of_motion, list(campaigns), jobs=jobs or default_jobs())
    asked = {m.motion: about for m, about in found}
    return DesignStudy(tuple(m for m, _ in found), asked, dict(GUARD), effort)


def _together(motions: list[str], progress: Tell | None) -> dict[str, Tell]:
    """Progress of each of the motions that go on side by side, as a share of them all."""
    shares, lock = dict.fromkeys(motions, 0.0), Lock()

    def tell(motion: str, what: str, share: float) -> None:
        with lock:
            shares[motion] = max(shares[motion], share)
            if progress:
                progress(f"{motion}, {what}", sum(shares.values()) / len(shares))

    return {m: partial(tell, m) for m in motions}


def required_of(plant: ParameterSet, taken: Taken) -> Requirement:
    """What a plant's rig states, less what is taken away."""
    found = requirement(replace(plant, remainder={}) if taken.remainder else plant)
    gone = {n: 0.0 for n, away in (("dead_time", taken.dead_time), ("load", taken.load)) if away}
    gone |= {"noise": 0.0, "quantum": 0.0} if taken.noise else {}
    found = replace(found, conditions=replace(found.conditions, **gone))
    return replace(found, box=Box(plant, ()).leaving(found.box.remainder)) if taken.box else found


def _at(stage: str, tell: Tell) -> Tell:
    """Progress within a stage, as a share of the motion's time."""
    place = STAGES.index(stage)
    before = sum(SHARES[:place])
    return lambda what, share: tell(what, before + SHARES[place] * min(max(share, 0.0), 1.0))


def asked_of_trace(checksum: str, start: ParameterSet | None, seed: int) -> dict[str, Any]:
    """What the plant that a trace revises follows from, by which its stage is known again: the start's rig
    too, since task and limits of the design are those of its file."""
    given = {} if start is None else {"rig": start.rig.record}
    return {"campaign": checksum, "start": None if start is None else start.values, "seed": seed, **given}


def _traced(
    motion: str,
    data: Campaign,
    start: ParameterSet | None,
    folder: Path,
    stages: Stages,
    seed: int,
    tell: Tell,
) -> tuple[ParameterSet, dict[str, Any]]:
    """The revised plant, and what the trace said."""
    path = folder / f"plant-{motion}.toml"

    def work() -> dict[str, Any]:
        trace, plant = trace_for_design(data, start, seed, _at("trace", tell))
        dump(plant, path)
        return {
            "verdict": trace.verdict, "before": trace.before, "after": trace.after, "noise": trace.noise,
            "effects": [{"name": e.name, "form": e.form, "stage": e.stage} for e in trace.effects],
            "remarks": list(trace.remarks), "plant": path.read_text(encoding="utf-8"),
        }  # fmt: skip

    found = stages.done(f"trace-{motion}", asked_of_trace(data.checksum, start, seed), work)
    if not path.exists() or path.read_text(encoding="utf-8") != found["plant"]:
        path.write_text(found["plant"], encoding="utf-8")
    return load(path), found


def _designed(
    motion: str,
    plant: ParameterSet,
    traced: dict[str, Any],
    required: Requirement,
    stages: Stages,
    effort: DesignEffort,
    seed: int,
    jobs: int | None,
    tell: Tell,
) -> MotionDesign:
    """All that follows the trace."""
    wrist, about = required.wrist, requirement_record(required)
    spent = {n: v for n, v in vars(effort).items() if n != "mpc"}
    asked = {"plant": traced["plant"], "requirement": about, "seed": seed, "effort": spent}
    designs = stages.done(
        f"tune-{motion}", asked, lambda: tuned_designs(required, effort, seed, jobs, _at("tune", tell))
    )
    if effort.mpc:
        designs |= stages.done(
            f"mpc-{motion}", asked, lambda: mpc_design(required, seed, effort.rounds, jobs, _at("tune", tell))
        )
    relaxed = designs.pop("relaxed")
    evidence, designs = confirmed(
        motion, required, designs, asked, stages, effort, seed, jobs, _at("check", tell)
    )
    best = best_of(designs)
    gains = designs[best]["gains"]
    mine = {**asked, "gains": gains}
    controller = with_gains(wrist, gains)

    def priced() -> list[dict[str, Any]]:
        rows: list[dict[str, Any]] = stages.done(
            f"prices-{motion}", {**mine, "designs": designs},
            lambda: {"rows": price_rows(required, designs, jobs, _at("prices", tell))},
        )["rows"]  # fmt: skip
        return rows

    def proved() -> dict[str, Any]:
        return kept_proof(stages, motion, required, controller, about["dead_time_s"][1])

    # The proof is Python on one processor, the simulations are compiled: side by side they share both.
    side_by_side: list[Callable[[], Any]] = [priced, proved]
    prices, proof = each(lambda work: work(), side_by_side, jobs=jobs or default_jobs())
    evidence["proved"] = proof
    _at("page", tell)("steps", 0.0)
    shown = stages.done(
        f"shown-{motion}", {**mine, "evidence": evidence},
        lambda: {
            "matrix": matrix(required, controller, evidence), "band": step_band(required, controller, seed),
        },
    )  # fmt: skip
    return MotionDesign(
        motion, plant, left_out(plant), {k: v for k, v in traced.items() if k != "plant"}, designs, best,
        evidence, (*prices, proved_row(prices, best, proof)), tuple(shown["matrix"]), shown["band"], relaxed,
    )  # fmt: skip
