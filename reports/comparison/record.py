"""A study of controllers for machines: what goes into JSON and CSV."""

import csv
import io
from dataclasses import asdict
from math import isfinite
from typing import Any

from design.comparison.compare import Comparison, row_record
from design.contest import Contest, contest_record
from design.studies.decision import Decision
from design.studies.study import Study
from reports.comparison.contest.words import sentences
from reports.comparison.costs import break_even_record, ledger_record
from reports.comparison.verdict_words import verdict_sentences
from reports.shared.figures.fit import fit_record
from reports.shared.html import Made
from reports.shared.tuning import tuning_record


def comparison_record(study: Study, made: Made) -> dict[str, Any]:
    """The study as dictionaries, lists, numbers and text, for `plants.files.json_text`.

    Keys: verdicts, limits, standings, rows (see `design.comparison.compare.row_record`), tunings, plants,
    fits (these three by motion), contest (see `design.contest.contest_record`), break_even (rows by
    motion, see `design.comparison.break_even.BreakEven.rows`), ledger (times [s] by motion and controller),
    each of these three None where there was none, decisions (what is recommended, by motion), dead_time
    (overshoot by motion, see `design.comparison.behind_dead_time.DeadTimeSweep.rows`), and made.
    """
    comparison, contest = study.comparison, study.contest
    return {
        "verdicts": verdict_sentences(study),
        "limits": comparison.limits.named,
        "standings": [asdict(s) for s in comparison.standings],
        "rows": [row_record(r) for r in comparison.rows],
        "tunings": {m: tuning_record(a, m) for m, a in study.answers.items()},
        "plants": {m: s.record for m, s in study.plants.items()},
        "fits": {m: fit_record(f) for m, f in study.fits.items()},
        "contest": contest_record(contest) | {"said": sentences(contest)} if contest else None,
        "break_even": break_even_record(study.break_even),
        "ledger": ledger_record(study.execution_times),
        "decisions": {m: decision_record(d) for m, d in study.decisions.items()},
        "dead_time": {m: sweep.rows() for m, sweep in study.late.items()},
        "made": asdict(made),
    }


def decision_record(d: Decision) -> dict[str, Any]:
    """What is recommended of a motion for machines, without the curves of its steps."""
    return {
        "controller": d.controller, "gains": dict(d.gains), "holds": d.holds,
        "evidence": dict(d.evidence), "limits": list(d.matrix), "candidates": dict(d.candidates),
    }  # fmt: skip


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
