"""A comparison for machines: JSON and CSV."""

import csv
import io
import json
import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from design.compare import Comparison, row_record
from design.tuning import Tuning
from plants.quantities import ParameterSet
from reports.fitted import Fit
from reports.html import Made

UNITS = {"Kp": "kPa/deg", "Ki": "kPa/(deg s)"}


def comparison_record(
    comparison: Comparison,
    tunings: Mapping[str, Tuning],
    sets: Mapping[str, ParameterSet],
    fits: Mapping[str, Fit],
    made: Made,
) -> dict[str, Any]:
    """The comparison as dictionaries, lists, numbers and text; what is infinite becomes None.

    Keys: verdicts, limits, standings, rows (see `design.compare.row_record`), tunings, plants,
    fits (these three by motion) and made.
    """
    record = {
        "verdicts": list(comparison.verdicts),
        "limits": comparison.limits.named,
        "standings": [asdict(s) for s in comparison.standings],
        "rows": [row_record(r) for r in comparison.rows],
        "tunings": {m: _tuning(t) for m, t in tunings.items()},
        "plants": {m: _plant(s) for m, s in sets.items()},
        "fits": {m: _fit(f) for m, f in fits.items()},
        "made": asdict(made),
    }
    plain: dict[str, Any] = _finite(record)
    return plain


def json_text(record: Mapping[str, Any]) -> str:
    """A record as JSON that any reader takes."""
    return json.dumps(record, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def csv_text(comparison: Comparison) -> str:
    """The rows of the table as CSV; what is infinite is an empty cell."""
    records = [row_record(r) for r in comparison.rows]
    text = io.StringIO()
    writer = csv.DictWriter(text, fieldnames=list(records[0]) if records else ["motion"], lineterminator="\n")
    writer.writeheader()
    writer.writerows(records)
    return text.getvalue()


def _tuning(t: Tuning) -> dict[str, Any]:
    return {
        "Kp": t.Kp, "Ki": t.Ki, "units": UNITS, "feasible": t.feasible, "active_constraint": t.active,
        "cost": t.problem.cost, "worst_cost": float(t.at.cost[0]),
        "worst_case": t.problem.scenarios[int(t.at.cost_at[0])].name,
        "values": {n: float(v[0]) for n, v in t.at.values.items()},
        "optimality": {
            "map_points": t.region.points, "map_resolution": list(t.region.resolution), "spread": t.spread,
            "on_edge": t.on_edge, "searches": [asdict(s) for s in t.searches],
        },
    }  # fmt: skip


def _plant(s: ParameterSet) -> dict[str, Any]:
    return {
        n: {
            "value": p.value, "unit": p.unit,
            "provenance": {"kind": type(p.provenance).__name__.lower(), **vars(p.provenance)},
        }
        for n, p in s.parameters.items()
    }  # fmt: skip


def _fit(f: Fit) -> dict[str, Any]:
    return {
        "campaign": f.campaign.name, "axis": f.campaign.axis, "checksum": f.campaign.checksum,
        "before": _plant(f.before), "fitted": _plant(f.fitted), "noise": f.noise,
        "fit_rmse": f.fit_rmse, "validate_rmse": f.validate_rmse,
        "validate_rmse_before": f.validate_rmse_before,
    }  # fmt: skip


def _finite(value: Any) -> Any:
    """The same value, mappings and sequences made plain, numbers that JSON lacks made None."""
    if isinstance(value, Mapping):
        return {str(k): _finite(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(v) for v in value]
    if hasattr(value, "tolist"):
        return _finite(value.tolist())
    return None if isinstance(value, float) and not math.isfinite(value) else value
