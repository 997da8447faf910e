"""A design for machines: what is recommended and why, prices, and what the traces said."""

from typing import Any

from design.studies.design_study import DesignStudy, MotionDesign


def design_record(study: DesignStudy) -> dict[str, Any]:
    """A design as dictionaries, lists, numbers and text, for JSON."""
    prices = [
        {
            "guarantee": r["guarantee"], "motion": m.motion, "controller": r["controller"],
            "sensors": r["sensors"],
            "gains": r["gains"], "worst_iae_deg_s": r["worst_iae_deg_s"],
            "worst_settling_s": r["worst_settling_s"], "ratio_to_bound": r["ratio_to_bound"],
            "worst_overshoot_percent": r["worst_overshoot_percent"], "holds_its_own": r["feasible"],
        }
        for m in study.motions
        for r in m.prices
    ]  # fmt: skip
    return {
        "recommended": {m.motion: _recommended(m) for m in study.motions},
        "prices": prices,
        "trace": {m.motion: dict(m.trace) for m in study.motions},
        "requirement": dict(study.requirements),
        "guard": dict(study.guard),
        "holds": study.holds,
        "limits": {m.motion: list(m.matrix) for m in study.motions},
        "designs": {m.motion: dict(m.designs) for m in study.motions},
    }


def _recommended(m: MotionDesign) -> dict[str, Any]:
    samples, worst, proved = (m.evidence[n] for n in ("samples", "worst_case", "proved"))
    return {
        "controller": m.recommended,
        "gains": m.gains,
        "holds": m.holds,
        "left_out": list(m.left_out),
        "would_have_to_go": m.relaxed,
        "evidence": {
            "samples": {n: samples[n] for n in ("broken", "total", "upper_bound", "out_of_reach")} |
            {"worst_iae_deg_s": samples["worst_iae_deg_s"], "worst_settling_s":
            samples["worst_settling_s"]}, "worst_case": {n: worst[n] for n in ("runs", "broken",
            "overshoot_percent", "excess", "excess_of",
                                                 "scenario", "worst_iae_deg_s")},
            "proved": {n: proved[n] for n in ("status", "rate_1_s", "dead_time_s", "covers_task", "rungs")},
        },
    }  # fmt: skip
