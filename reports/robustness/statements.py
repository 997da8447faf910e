"""Statements for machines: what is claimed, what came of it, and why."""

from collections.abc import Mapping
from typing import Any

from design.robustness.certificates.continuous.virgin import VirginBounds
from design.robustness.certificates.statements import (
    VirginTimes,
)
from design.robustness.intervals import AssumedShare, Given, Origin
from design.robustness.statement import Statement
from reports.robustness.claims import claim_words
from reports.robustness.reasons import because, virgin_words


def statement_record(s: Statement) -> dict[str, Any]:
    """A statement for JSON."""
    evidence: dict[str, Any] = dict(s.evidence)
    if isinstance(s.reason, VirginTimes):
        evidence = virgin_record(s.reason.bounds)
    if "virgin_curve" in evidence:
        evidence["virgin_curve"] = virgin_record(evidence["virgin_curve"])
    if "region" in evidence:
        evidence["region"] = {**evidence["region"], "why": region_words(evidence["region"])}
    return {
        "statement": claim_words(s.claim),
        "status": s.status.value,
        "holds": s.holds,
        "value": s.value,
        "unit": s.unit,
        "branch": s.branch,
        "because": because(s),
        **evidence,
    }


def virgin_record(bounds: VirginBounds) -> dict[str, Any]:
    """Bounds of the time on the virgin curve for JSON."""
    if bounds.stuck is not None:
        return {"leaves": False, "why": virgin_words(bounds)}
    times = {"earliest_s": bounds.earliest, "latest_s": bounds.latest, "clipped": bounds.clipped}
    return {"leaves": True, **times, "q_kPa": [bounds.q_least, bounds.q_most]}


def region_words(region: Mapping[str, Any]) -> str:
    """Why a region says nothing of a step, or has no shape in the states alone; empty where it has."""
    if region["largest_step_deg"] is None:
        if region.get("curved"):
            return "the outer branches are curved, so that no two planes bound the command"
        return "no step was found that is certain to keep the command in its range"
    return "not a set in x alone: commands within the dead time count too" if "S" in region["form"] else ""


def origin_words(origin: Origin) -> str:
    """Where an interval of a box comes from."""
    if isinstance(origin, Given):
        return "given"
    if not isinstance(origin, AssumedShare):
        return f"{origin.count:g} standard errors, {origin.data}"
    if origin.together:
        return f"assumed: {', '.join(origin.together)} within {100 * origin.share:g} %, together"
    without = ", fitted without standard error" if origin.fitted else ""
    return f"assumed: {100 * origin.share:g} % of the value{without}"
