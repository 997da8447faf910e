"""An assessment for machines."""

from typing import Any

from design.robustness.assess import Assessment
from design.robustness.disagreement import disagreements
from design.robustness.samples.monte_carlo import samples_record


def assessment_record(a: Assessment) -> dict[str, Any]:
    """Dictionaries, lists, numbers and text, for JSON; what is infinite becomes null there.

    ``certificates``, ``predictions``, ``samples``: lists of {statement, holds, value, branch, ...};
    ``worst_case``: the worst scenario found; beside them the gains, the box, the margins of every
    branch, and where the kinds disagree.
    """
    return {
        "axis": a.box.plant.axis,
        "Kp": float(a.controller.Kp),
        "Ki": float(a.controller.Ki),
        "stable": a.stable,
        "certificates": [s.record for s in a.certificates],
        "predictions": [s.record for s in a.predictions],
        "samples": [s.record for s in a.samples],
        "worst_case": a.worst.record,
        "disagreements": disagreements(a),
        "limits": a.limits.named,
        "box": {
            i.name: {"low": i.low, "nominal": i.nominal, "high": i.high, "unit": i.unit, "why": i.why}
            for i in a.box.intervals
        },
        "margins": list(a.margins),
        "sampled": samples_record(a.cases),
        "left_out_of_certificates": list(a.left_out),
    }
