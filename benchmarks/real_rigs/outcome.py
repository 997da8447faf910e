"""What came of tracing another rig, and its record: errors before and after, effects, what is left.

Errors are of free runs from the command, on whole held-out recordings.
"""

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.real_rigs.black_box import METHODS, Logged, Task, error
from benchmarks.real_rigs.data import Rig, checksums, convert
from plants.errors import InputError
from plants.measured.campaigns.begin import measured
from plants.measured.campaigns.campaign import Campaign, load_campaign
from plants.measured.campaigns.recording import Recording
from plants.measured.fitting.fit import CHANNELS, Fit
from plants.measured.fitting.free_run import FreeRun
from plants.measured.trace.result import Trace
from plants.measured.trace.trace import trace_campaign
from plants.parameters.quantities import Fitted

MADE = Path(__file__).parents[2] / "build" / "real"
DIGITS = 5
"""Significant digits that are kept: the rest differs from machine to machine."""


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
    learnt = stage.description
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


def line(said: Mapping[str, Any]) -> str:
    """A campaign in one line."""
    parts = [
        f"{ch}: {c['before']:.3g} -> {c['after']:.3g} (noise {c['noise_floor']:.2g})"
        for ch, c in said["channels"].items()
        if c.get("after") is not None
    ]
    names = ", ".join(e["name"] for e in said["effects"]) or "no effect"
    return f"{said['campaign']}: {said['stopped'] or '; '.join([said['verdict'], names, *parts])}"
