"""What is decided of a motion: the controller that is recommended, and the evidence for exactly its gains.

Candidates are judged by one requirement on fresh samples and by a search for the worst case, neither of which
took part in their tuning; proofs are asked for of the recommended one alone.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from design.controllers.pi import PI
from design.robustness.checks import check, worst_found
from design.robustness.requirement import Requirement, requirement_record
from design.studies.proof import kept_proof, not_asked
from design.studies.shown.limits_matrix import matrix, step_band
from design.studies.stages import NOTHING_KEPT, Stages

Tell = Callable[[str, float], None]
SAMPLES, RUNS = 2000, 5000
"""Fresh samples, and runs of the search for the worst case, of each candidate."""


@dataclass(frozen=True)
class Decision:
    """The recommended controller of a motion, its gains, and what is known of them.

    evidence: fresh samples, worst case, proof; matrix: limits by what they hold under; band: the steps that
    are drawn; candidates: of each controller that was judged, how many samples and runs of the search broke a
    limit; dead_time: the longest of the requirement [s].
    """

    motion: str
    controller: str
    gains: Mapping[str, float]
    evidence: Mapping[str, Any]
    matrix: tuple[Mapping[str, Any], ...]
    band: Mapping[str, Any]
    candidates: Mapping[str, Mapping[str, int]]
    dead_time: float

    @property
    def holds(self) -> bool:
        """Whether neither a fresh sample nor the search for the worst case broke a limit, nor a margin on a
        corner of the box."""
        broken = sum(self.evidence[n]["broken"] for n in ("samples", "worst_case"))
        return not broken and not any(v is False for row in self.matrix for v in row["held"].values())


AGAIN = 2
"""How often gains are tuned again from cases that break a limit in their check."""


def seeds(seed: int) -> tuple[int, int]:
    """Seeds of the fresh samples and of the search that check gains tuned with a seed."""
    return 1000 + seed, 2000 + seed


def of_check(motion: str, again: int = 0) -> str:
    """Name of the stage that checks the gains of a motion, or those that were tuned again."""
    return f"check-{motion}" + (f"-again-{again}" if again else "")


def checked(
    required: Requirement, controller: PI, samples: int, runs: int, seed: int, jobs: int | None, tell: Tell
) -> dict[str, Any]:
    """Fresh samples and the worst case found, neither of which took part in the tuning."""
    of_samples, of_search = seeds(seed)
    fresh = check(required, controller, samples, of_samples, jobs, lambda s, h: tell(s, 0.3 * h))
    worst = worst_found(required, controller, runs, of_search, jobs, lambda s, h: tell(s, 0.3 + 0.7 * h))
    broken = required.excess(fresh.values)
    return {
        "samples": {
            "broken": fresh.broken, "total": fresh.total, "upper_bound": fresh.upper_bound,
            "out_of_reach": fresh.out_of_reach, "worst_excess": float(broken.max()),
            "worst": {n: float(v.max()) for n, v in fresh.values.items()},
            "worst_iae_deg_s": fresh.worst_cost, "worst_settling_s": fresh.worst_settling_s,
        },
        "worst_case": {
            "runs": worst.runs, "broken": worst.broken,
            "overshoot_percent": worst.values["overshoot_percent"], "excess": worst.excess,
            "excess_of": worst.excess_of, "values": worst.values, "scenario": worst.case.name,
            "worst_iae_deg_s": worst.worst_cost,
            "dearest": None if worst.dearest is None else worst.dearest.name,
        },
        "linear_excess": required.linear_excess(controller),
    }  # fmt: skip


def settings(controller: PI) -> dict[str, float]:
    """Gains of a PI as a design keeps them, Kp [kPa/deg], Ki [kPa/(deg s)], weight b, filter Tf [s].

    >>> settings(PI(2.0, 5.0))
    {'Kp': 2.0, 'Ki': 5.0, 'b': 1.0, 'Tf': 0.0}
    """
    return {
        "Kp": float(controller.Kp), "Ki": float(controller.Ki),
        "b": float(getattr(controller, "b", 1.0)), "Tf": float(getattr(controller, "Tf", 0.0)),
    }  # fmt: skip


def decide(
    motion: str, required: Requirement, candidates: Mapping[str, PI], seed: int = 0,
    jobs: int | None = None, progress: Tell | None = None, samples: int = SAMPLES, runs: int = RUNS,
    prove: bool = True, stages: Stages = NOTHING_KEPT,
) -> Decision:  # fmt: skip
    """Judge candidates by a requirement and recommend the first without a broken limit in samples and search;
    otherwise the one with the smallest share of samples that break a limit.

    prove: ask for certificates, which takes a minute, unless the stages of a design have them; without,
    everything is open.  Samples and runs of gains that a design has checked are the design's, so that a
    number is the same wherever it is shown.
    """
    tell = progress or (lambda stage, share: None)
    found, asked = {}, requirement_record(required)
    for place, (name, c) in enumerate(candidates.items()):
        share = place / len(candidates)
        tell(f"check {name}", 0.8 * share)
        mine = {"requirement": asked, "gains": settings(c)}
        kept = (stages.kept(of_check(motion, again), mine) for again in range(AGAIN + 1))
        of_design = next((k for k in kept if k is not None), None)
        found[name] = of_design or checked(required, c, samples, runs, seed, jobs, lambda s, h: None)

    def badness(name: str) -> tuple[bool, float]:
        e = found[name]
        broken = e["samples"]["broken"] + e["worst_case"]["broken"]
        linear = max(e["linear_excess"].values(), default=0.0) > 0.0
        return bool(broken) or linear, e["samples"]["broken"] / max(1, e["samples"]["total"])

    best = min(found, key=badness)
    tell(f"proof of {best}", 0.8)
    evidence, controller = found[best], candidates[best]
    late = required.space.dead_time
    evidence["proved"] = kept_proof(stages, motion, required, controller, late) if prove else not_asked(late)
    counts = {
        n: {"samples_broken": e["samples"]["broken"], "samples": e["samples"]["total"],
            "runs_broken": e["worst_case"]["broken"], "runs": e["worst_case"]["runs"]}
        for n, e in found.items()
    }  # fmt: skip
    return Decision(
        motion, best, settings(controller), evidence, tuple(matrix(required, controller, evidence)),
        step_band(required, controller, seed), counts, late,
    )  # fmt: skip
