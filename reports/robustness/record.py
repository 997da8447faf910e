"""An assessment for machines."""

from typing import Any

from design.robustness.assess import Assessment
from design.robustness.samples.monte_carlo import samples_record
from reports.robustness.disagreements import disagreement_sentences
from reports.robustness.statements import origin_words, statement_record


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
        **{n: float(getattr(a.controller, n)) for n in ("b", "Tf") if hasattr(a.controller, n)},
        "stable": a.stable,
        "certificates": [statement_record(s) for s in a.certificates],
        "predictions": [statement_record(s) for s in a.predictions],
        "samples": [statement_record(s) for s in a.samples],
        "worst_case": a.worst.record,
        "disagreements": disagreement_sentences(a),
        "limits": a.limits.named,
        "box": {
            i.name: {
                "low": i.low,
                "nominal": i.nominal,
                "high": i.high,
                "unit": i.unit,
                "why": origin_words(i.origin),
            }
            for i in a.box.intervals
        },
        "margins": list(a.margins),
        "sampled": samples_record(a.cases),
        "left_out_of_certificates": list(a.left_out),
    }
