"""A check for machines."""

from typing import Any

from design.studies.check.check import LogCheck
from reports.check.words import title


def check_record(check: LogCheck) -> dict[str, Any]:
    """A check as dictionaries, lists, numbers and text, for JSON."""
    e, r = check.envelope, check.residual
    return {
        "log": check.log.name,
        "axis": check.plant.axis,
        "verdict": check.verdict,
        "words": title(check),
        "promise_kept": check.kept,
        "own_controller": check.own_controller,
        "envelope": {
            "samples": e.samples, "score": e.score, "largest_of_samples": e.largest,
            "first_departure": None if e.first is None else f"{e.first.name}, stair {e.first.stair + 1}",
            "figures": [
                {
                    "stair": f.stair + 1, "reference_deg": check.stairs[f.stair].reference, "name": f.name,
                    "unit": f.unit, "value": f.value, "samples": [f.low, f.middle, f.high],
                    "score": f.score, "departs": f.departs,
                }
                for f in e.figures
            ],
        },
        "residual": {
            "new": r.new,
            "channels": [
                {"channel": c.channel, "rms": c.rms, "before": c.before, "allowed": c.allowed, "new": c.new}
                for c in r.channels
            ],
            "change": None if r.change is None else dict(vars(r.change)),
        },
    }  # fmt: skip
