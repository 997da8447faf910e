"""Fits and comparisons for machines: what goes into JSON and CSV."""

import csv
import io
from collections.abc import Mapping
from dataclasses import asdict
from math import isfinite
from typing import Any

from design.answer import tuning_record
from design.break_even import BreakEven
from design.compare import Comparison, row_record
from design.contest import Contest, contest_record
from design.contest.words import sentences
from design.mpc.timing import Ledger
from design.tuning import Tuning
from plants.quantities import Fitted, ParameterSet
from reports.comparison_costs import break_even_record, ledger_record
from reports.fitted import Fit
from reports.html import Made


def comparison_record(
    comparison: Comparison,
    tunings: Mapping[str, Tuning],
    sets: Mapping[str, ParameterSet],
    fits: Mapping[str, Fit],
    made: Made,
    contest: Contest | None = None,
    break_even: Mapping[str, BreakEven] | None = None,
    ledger: Mapping[str, Mapping[str, Ledger]] | None = None,
) -> dict[str, Any]:
    """The comparison as dictionaries, lists, numbers and text, for `plants.files.json_text`.

    Keys: verdicts, limits, standings, rows (see `design.compare.row_record`), tunings, plants,
    fits (these three by motion), contest (see `design.contest.contest_record`), break_even (rows by
    motion, see `design.break_even.BreakEven.rows`), ledger (times [s] by motion and controller), each of
    these three None where there was none, and made.
    """
    return {
        "verdicts": list(comparison.verdicts),
        "limits": comparison.limits.named,
        "standings": [asdict(s) for s in comparison.standings],
        "rows": [row_record(r) for r in comparison.rows],
        "tunings": {m: tuning_record(t, m) for m, t in tunings.items()},
        "plants": {m: s.record for m, s in sets.items()},
        "fits": {m: fit_record(f) for m, f in fits.items()},
        "contest": contest_record(contest) | {"said": sentences(contest)} if contest else None,
        "break_even": break_even_record(break_even),
        "ledger": ledger_record(ledger),
        "made": asdict(made),
    }


def csv_text(comparison: Comparison) -> str:
    """The rows of the table as CSV; what is infinite is an empty cell."""
    return _csv([row_record(r) for r in comparison.rows])


def contest_csv_text(contest: Contest) -> str:
    """The scores of a contest as CSV, as in `design.contest.contest_record`; infinite is an empty cell."""
    records = [
        {k: None if isinstance(v, float) and not isfinite(v) else v for k, v in record.items()}
        for record in contest_record(contest)["scores"]
    ]
    return _csv(records)


def _csv(records: list[dict[str, Any]]) -> str:
    text = io.StringIO()
    writer = csv.DictWriter(text, fieldnames=list(records[0]) if records else ["motion"], lineterminator="\n")
    writer.writeheader()
    writer.writerows(records)
    return text.getvalue()


def fit_record(fit: Fit) -> dict[str, Any]:
    """A fit: its data, the parameters that were fitted, its errors by channel, how the search went."""
    return {
        "campaign": fit.campaign.name,
        "sha256": fit.campaign.checksum,
        "axis": fit.campaign.axis,
        "parameters": {
            n: {"value": p.value, "unit": p.unit, "std_error": p.provenance.std_error}
            for n, p in fit.fitted.parameters.items()
            if isinstance(p.provenance, Fitted)
        },
        "before": {n: p.value for n, p in fit.before.parameters.items()},
        "noise_floor": fit.noise,
        "validate_rmse": fit.validate_rmse,
        "validate_rmse_before": fit.validate_rmse_before,
        "fit_rmse": fit.fit_rmse,
        "at_bounds": list(fit.at_bounds),
        "undetermined": list(fit.undetermined),
        "remarks": fit.remarks,
        "stages": {n: {"costs": list(e.costs), "agreeing": e.agreeing} for n, e in fit.stages.items()},
    }
