"""``python -m benchmarks.real_rigs``: traces of other people's rigs, whatever comes of them.

Reads the folder that WRIST_DATA names, makes campaigns of it in ``build/real``
(`benchmarks.real_data` says how), and writes figures and numbers, never the data,
to ``reports/examples/real``, and the table of all rigs into the guide.  With
words it does only those rigs in whose names one of them is, as in
``python -m benchmarks.real_rigs seal damper``, and keeps the others' numbers.
Exit codes: 0 done, or WRIST_DATA is unset; 1 a campaign could not be traced,
which the numbers then say.
"""

import json
import os
import re
import sys
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import friction
from benchmarks.black_box import METHODS, Logged, Task, error
from benchmarks.real_data import Rig, checksums, convert, rigs
from benchmarks.real_figures import draw_rig
from plants.errors import InputError
from plants.files import json_text, write_atomically
from plants.measured.begin import measured
from plants.measured.campaign import Campaign, load_campaign
from plants.measured.fit import CHANNELS, Fit
from plants.measured.free_run import FreeRun
from plants.measured.recording import Recording
from plants.measured.trace.result import Trace
from plants.measured.trace.trace import trace_campaign
from plants.parameters.quantities import Fitted
from reports.shared.figures.style import save

ROOT = Path(__file__).parent.parent
MADE = ROOT / "build" / "real"
KEPT = ROOT / "reports" / "examples" / "real"
GUIDE = ROOT / "docs" / "how-trace-decides.md"
TABLE = re.compile(r"^\| rig \|.*\n(\|.*\n)*", re.MULTILINE)
"""The table of all rigs, which stands in the guide."""

DIGITS = 5
"""Significant digits that are kept: the rest differs from machine to machine."""


ABOUT = {
    "real-rigs.json": "traces of other people's measured rigs, started from the log alone; errors are of "
    "free runs from the command, on whole held-out recordings; made by python -m benchmarks.real_rigs",
    "friction.json": "friction of other people's measured rigs, from displacement to force; errors are of "
    "free runs on rows held out; made by python -m benchmarks.real_rigs",
}
"""What the kept files say of themselves, by name."""

INTERVAL = "95 %, bootstrap over blocks of 2 s, or over recordings where these are shorter"


@dataclass(frozen=True)
class Outcome:
    """What came of a rig: its trace, or None and why there is none, with the declared fit if that
    could be made; and what was warned of on the way."""

    rig: Rig
    campaign: Campaign
    trace: Trace | None
    fit: Fit | None
    stopped: str | None
    warned: tuple[str, ...]


def outcome(rig: Rig, data: Path, made: Path = MADE) -> Outcome:
    """Convert, load, fit and trace a rig."""
    place = convert(rig, data, made)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        campaign = load_campaign(place)
        trace, fit, stopped = None, None, None
        try:
            trace = trace_campaign(campaign)
            fit = trace.fit
        except (InputError, ValueError) as error:
            stopped = f"{type(error).__name__}: {error}"
    # A warning names the file that was made here; its place on this machine is nobody's business.
    warned = tuple(dict.fromkeys(str(w.message).replace(f"{place}/", "") for w in caught))
    return Outcome(rig, campaign, trace, fit, stopped, warned)


def record(found: Outcome, data: Path) -> dict[str, Any]:
    """What came of a rig, for `plants.files.json_text`."""
    rig, c, trace, fit = found.rig, found.campaign, found.trace, found.fit
    lengths = {role: [len(r.time) for r in rs] for role, rs in (("fit", c.fit), ("held_out", c.validate))}
    each = lengths["fit"] + lengths["held_out"]
    return {
        "campaign": rig.name,
        "title": rig.title,
        "origin": rig.origin,
        "licence": rig.licence,
        "sha256": checksums(rig, data),
        "fit": list(rig.fit),
        "held_out": list(rig.validate),
        "stage": rig.stage,
        "mapping": list(rig.mapping),
        "assumed": list(rig.assumed),
        "sample_time_s": rig.sample_time,
        "rows": {role: sum(n) for role, n in lengths.items()},
        "rows_of_a_recording": {"least": min(each), "most": max(each)},
        "stopped": found.stopped,
        "warned": list(found.warned),
        "verdict": None if trace is None else trace.verdict,
        "channels": {ch: _channel(found, ch) for ch in CHANNELS if measured(c.validate[0], ch) is not None},
        "declared": None if fit is None else _declared(fit),
        "effects": [] if trace is None else [_effect(e) for e in trace.effects],
        "cannot_judge_count": None if trace is None else len(trace.cannot_judge),
        "cannot_judge": None if trace is None else list(trace.cannot_judge),
        "unexplained": None if trace is None else [_left(s) for s in trace.unexplained],
        "remarks": [] if trace is None else list(trace.remarks),
        "explained_share": None if trace is None else trace.explained_share,
    }


def others(found: Outcome) -> dict[str, Any]:
    """Errors of what users would take instead, from the command to the last channel, on the same rows."""
    last = CHANNELS[-1] if found.rig.stage == "wrist" else "pressure_kPa"

    def logged(r: Recording) -> Logged:
        truth = measured(r, last)
        assert truth is not None  # a campaign of this stage has it
        return Logged(r.command[:, None], truth, found.rig.sample_time)

    task = Task(*(tuple(map(logged, runs)) for runs in (found.campaign.fit, found.campaign.validate)))
    return {name: error(task, method) for name, method in METHODS.items()}


def _channel(found: Outcome, channel: str) -> dict[str, Any]:
    """Errors of free runs on the episodes held out, beside the noise and what a constant would leave."""
    truth = [measured(r, channel) for r in found.campaign.validate]
    held = [v - v[0] for v in truth if v is not None]
    said: dict[str, Any] = {
        "first_value_held_rmse": float(np.sqrt(np.mean(np.concatenate(held) ** 2))),
        "noise_floor": None if found.fit is None else found.fit.noise[channel],
        "before": None if found.fit is None else found.fit.validate_rmse[channel],
    }
    if found.trace is not None:
        t = found.trace
        said |= {
            "before": t.before[channel],
            "before_interval_95": t.before_interval[channel],
            "after": t.after[channel],
            "after_interval_95": t.after_interval[channel],
            "by_episode": [_episode(p, channel) for p in t.runs if p.role == "validate"],
        }
    return said


def _episode(run: FreeRun, channel: str) -> dict[str, Any]:
    truth = measured(run.recording, channel)
    sides = (
        (run.pressure_before, run.pressure) if channel == "pressure_kPa" else (run.angle_before, run.angle)
    )
    before, after = (None if s is None or truth is None else _rms(s - truth) for s in sides)
    return {"name": run.recording.name, "rows": len(run.recording.time), "before": before, "after": after}


def _rms(values: Any) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _declared(fit: Fit) -> dict[str, Any]:
    fitted = fit.fitted.parameters.items()
    return {
        "parameters": {
            n: {"value": p.value, "unit": p.unit, "std_error": p.provenance.std_error}
            for n, p in fitted
            if isinstance(p.provenance, Fitted)
        },
        "at_bounds": list(fit.at_bounds),
        "undetermined": list(fit.undetermined),
    }


def _effect(effect: Any) -> dict[str, Any]:
    return {
        "name": effect.name,
        "form": effect.form,
        "stage": effect.stage,
        "alternatives": list(effect.alternatives),
        "parameters": {
            n: {"value": v, "unit": unit, "std_error": e} for n, (v, unit, e) in effect.parameters.items()
        },
    }


def _left(stage: Any) -> dict[str, Any]:
    learnt = stage.learnt
    return {
        "stage": stage.name,
        "depends_on": list(stage.after.depends_on),
        "learnt_share": None if learnt is None else learnt.described,
        "learnt_variables": [] if learnt is None else list(learnt.variables),
    }


def shortened(value: Any) -> Any:
    """The same with floats of DIGITS significant digits."""
    if isinstance(value, Mapping):
        return {k: shortened(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [shortened(v) for v in value]
    return float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value


def main(names: Sequence[str] = ()) -> int:
    """Trace all rigs and find the friction of all tasks, one after the other; or only those in whose names
    one of `names` is, and keep what there is of the others."""
    folder = os.environ.get("WRIST_DATA")
    if not folder:
        print("WRIST_DATA is not set: no measured data at hand, nothing done")
        return 0
    data, stopped = Path(folder), False

    def asked(name: str) -> bool:
        return not names or any(n in name for n in names)

    for rig in filter(lambda r: asked(r.name), rigs(data)):
        found = outcome(rig, data)
        said = record(found, data) | {"others": others(found)}
        stopped = stopped or found.stopped is not None
        if found.fit is not None:
            save(draw_rig(found.rig, found.fit, found.trace), KEPT / f"{rig.name}.png", dpi=150)
        print(line(said), flush=True)
        _keep("real-rigs.json", "campaigns", "campaign", said, [r.name for r in rigs(data)])
    for task in filter(lambda t: asked(t.name), friction.tasks(data)):
        law = friction.record(task)
        print(f"{task.name}: {law['errors']['ours']}", flush=True)
        _keep("friction.json", "tasks", "task", law, [t.name for t in friction.tasks(data)])
    text = GUIDE.read_text(encoding="utf-8")
    write_atomically(GUIDE, TABLE.sub(lambda _: kept_table(), text))
    return int(stopped)


def _keep(name: str, key: str, by: str, said: Mapping[str, Any], order: Sequence[str]) -> None:
    """Put a record among those that a file keeps under `key`, in the place of the one of its name."""
    place = KEPT / name
    old = json.loads(place.read_text(encoding="utf-8"))[key] if place.is_file() else []
    records = {r[by]: r for r in old} | {said[by]: shortened(said)}
    content = {"what": ABOUT[name], "interval": INTERVAL, key: [records[n] for n in order if n in records]}
    write_atomically(place, json_text(content))


def kept_table() -> str:
    """The table of all rigs whose numbers are kept."""
    kept = [json.loads(p.read_text(encoding="utf-8")) for n in ABOUT if (p := KEPT / n).is_file()]
    found = {k: content[k] for content in kept for k in ("campaigns", "tasks") if k in content}
    return table(found.get("campaigns", ()), found.get("tasks", ()))


def table(campaigns: Sequence[Mapping[str, Any]], tasks: Sequence[Mapping[str, Any]]) -> str:
    """All rigs in Markdown: error of the standard model and of ours, what explains it, and the others'."""
    rows = [_campaign_row(c) for c in campaigns] + [_task_row(t) for t in tasks]
    head = ["rig", "rows, fit + held out", "declared or Coulomb", "ours", "explained", *METHODS, "Bouc-Wen"]
    lines = [head, ["---"] * len(head), *rows]
    return "".join(f"| {' | '.join(row)} |\n" for row in lines)


def _campaign_row(c: Mapping[str, Any]) -> list[str]:
    channel, unit = (CHANNELS[1], "deg") if c["stage"] == "wrist" else (CHANNELS[0], "kPa")
    found = c["channels"][channel]
    names = ", ".join(f"`{e['name']}`" for e in c["effects"])
    share = (c["explained_share"] or {}).get(channel)
    why = f"{names}: {100 * share:.0f} %" if names and share is not None else "no effect earned its place"
    before, after = (
        {"error": found[s], "interval_95": found[f"{s}_interval_95"]} for s in ("before", "after")
    )
    least = [before, after, *c["others"].values()]
    cells = [_said(before, least), _said(after, least), why]
    return [
        f"{c['title']} [{unit}]", f"{c['rows']['fit']} + {c['rows']['held_out']}", *cells,
        *(_said(c["others"][m], least) for m in METHODS), "–",
    ]  # fmt: skip


def _task_row(t: Mapping[str, Any]) -> list[str]:
    e = t["errors"]
    left, before = e["ours"]["error"], e["Coulomb"]["error"]
    share = f": {100 * (1.0 - (left / before) ** 2):.0f} %" if left and before and left < before else ""
    why = (", ".join(t["parts"]) or "Coulomb friction") + share
    least = list(e.values())
    return [
        f"{t['task']} [{t['unit']}]", f"{t['rows']['fit']} + {t['rows']['held_out']}",
        _said(e["Coulomb"], least), _said(e["ours"], least), why,
        *(_said(e[m], least) for m in METHODS), _said(e["Bouc-Wen"], least),
    ]  # fmt: skip


def _said(found: Mapping[str, Any], beside: Sequence[Mapping[str, Any]]) -> str:
    """An error to three digits with its interval, in bold where none beside it is less."""
    if found.get("error") is None:
        return str(found.get("why", "–"))
    shown = f"{found['error']:.3g}"
    least = min(float(f["error"]) for f in beside if f.get("error") is not None)
    low, high = (f"{v:.3g}" for v in found["interval_95"])
    return f"{f'**{shown}**' if found['error'] <= least else shown} ({low}–{high})"


def line(said: Mapping[str, Any]) -> str:
    """A campaign in one line."""
    parts = [
        f"{ch}: {c['before']:.3g} -> {c['after']:.3g} (noise {c['noise_floor']:.2g})"
        for ch, c in said["channels"].items()
        if c.get("after") is not None
    ]
    names = ", ".join(e["name"] for e in said["effects"]) or "no effect"
    return f"{said['campaign']}: {said['stopped'] or '; '.join([said['verdict'], names, *parts])}"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
