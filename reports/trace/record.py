"""A trace for machines: what ``wrist trace --json`` writes, in the keys that others read."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from design.synthesis.answer import UNITS as GAIN_UNITS
from design.synthesis.retune import Control, RetunedSide
from plants.measured.instrument.remark import habits
from plants.measured.trace.result import Named, StageTrace, Trace
from reports.shared.figures.fit import correlation_record
from reports.shared.tuning import refused
from reports.trace.control_words import NO_LOOP
from reports.trace.residual_words import UNITS, describe


def trace_record(trace: Trace, control: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """The answer of a trace as dictionaries, lists, numbers and text, for `plants.files.json_text`.

    Errors and the noise floor of a channel that was not logged are None.  `control`:
    what `control_record` gives, under the key ``control`` where there is one.  ``correlation``: of the errors
    of parameters that were estimated together, names under ``parameters``, rows under ``matrix``.
    """
    record: dict[str, Any] = {
        "axis": trace.campaign.axis,
        "verdict": trace.verdict,
        "before": _errors(trace.before),
        "after": _errors(trace.after),
        "noise_floor": {c: trace.noise.get(c) for c in UNITS},
        "effects": [effect_record(e) for e in trace.effects],
        "unexplained": _unexplained(trace.unexplained),
        "learnt_block": _block(trace),
        "cannot_judge": list(trace.cannot_judge),
        "law": _law(trace),
        "explained_share": {c.split("_")[0]: trace.explained_share.get(c) for c in UNITS},
        "remainder": _remainder(trace),
        "correlation": correlation_record(trace.correlations),
        "instrument": habits(trace.instrument),
    }
    return record if control is None else record | {"control": control}


def _block(trace: Trace) -> dict[str, Any] | None:
    """The learnt block: its form, the pressures that it was learnt on, and the errors without it; None where
    the plant has none."""
    block = trace.block
    if block is None or trace.named_only is None:
        return None
    ends = {"from": float(block.low), "to": float(block.high), "unit": trace.revised.kinds["learnt.low"].unit}
    parameters = {n: float(v) for n, v in vars(block).items()}
    return {
        "note": "a description, not a cause",
        "stage": "wrist",
        "form": block.FORM,
        "range": ends,
        "without": _errors(trace.named_only),
        "parameters": parameters,
    }


def _law(trace: Trace) -> dict[str, Any]:
    """The hysteresis law, and what the others leave on rows left out; none others where it was given."""
    chosen = trace.revised.law.NAME
    held_out = {} if trace.law is None else trace.law.with_effects or trace.law.held_out
    alone = {"alone": _errors(trace.law_alone)} if trace.law_alone else {}
    return {
        "name": chosen,
        **alone,
        "with_effects": bool(trace.law is not None and trace.law.with_effects),
        "held_out_rmse_deg": held_out.get(chosen),
        "others": [{"name": n, "held_out_rmse_deg": e} for n, e in held_out.items() if n != chosen],
    }


def _remainder(trace: Trace) -> dict[str, Any]:
    """What is left on held-out recordings without the noise, by channel, with what it depends on."""
    found: dict[str, Any] = {}
    on = {s.stage.channel: list(s.after.depends_on) for s in trace.stages}
    for channel, unit in UNITS.items():
        name, left = channel.split("_")[0], trace.remainder.get(channel)
        found[f"{name}_{unit}"] = None if left is None else left.rms
        found[f"{name}_share_of_range"] = None if left is None else left.share_of_range
        if left is not None:
            bands = [{"from_hz": edge, "share": share} for edge, share in left.spectrum.items()]
            found[f"{name}_spectrum"] = bands
            found[f"{name}_depends_on"] = on.get(channel, [])
            found[f"{name}_weight"] = None if left.weight is None else asdict(left.weight)
    return found


def _errors(errors: Mapping[str, float | None]) -> dict[str, float | None]:
    return {
        "angle_rmse_deg": errors.get("angle_deg"),
        "pressure_rmse_kPa": errors.get("pressure_kPa"),
    }


def effect_record(effect: Named) -> dict[str, Any]:
    """An effect with its parameters, for JSON."""
    return {
        "name": effect.name,
        "stage": effect.stage,
        "alternatives": list(effect.alternatives),
        "parameters": {
            n: {"value": value, "unit": unit, "std_error": error}
            for n, (value, unit, error) in effect.parameters.items()
        },
        "form": effect.form,
    }


def _unexplained(left: list[StageTrace]) -> dict[str, Any] | None:
    """The first stage in which something is left; all their names where there are several."""
    if not left:
        return None
    record = _left(left[0])
    return record | {"stages": [s.name for s in left]} if len(left) > 1 else record


def _left(stage: StageTrace) -> dict[str, Any]:
    after, learnt = stage.after, stage.description
    return {
        "stage": stage.name,
        "depends_on": list(after.depends_on),
        "description": describe(after, stage.stage.channel),
        "learnt": None
        if learnt is None
        else {
            "note": "a description, not a cause",
            "variables": list(learnt.variables),
            "described": learnt.described,
            "curves": [
                {"variable": c.variable, "at": list(map(float, c.at)), "term": list(map(float, c.term))}
                for c in learnt.curves
            ],
        },
    }


def control_record(control: Control | None) -> dict[str, Any]:
    """Both PIs as dictionaries, lists, numbers and text, for JSON; what is infinite becomes null there.
    Of a campaign without an angle (None), why there are none."""
    if control is None:
        return {"refusal": NO_LOOP}
    return {
        "judge": control.judge,
        "step_deg": control.task.step,
        "same": control.same,
        "tuned_without": list(control.left_out),
        "declared": _side_record(control.declared),
        "revised": _side_record(control.revised),
    }


def _side_record(side: RetunedSide) -> dict[str, Any]:
    found, j = side.tuning, side.judged
    record: dict[str, Any] = {"refusal": None if side.refusal is None else refused(side.refusal)}
    if found is None or j is None:
        return record | {"Kp": None, "Ki": None}
    names = ("iae_deg_s", "overshoot_percent", "settling_time_s", "steady_error_deg", "total_variation_V",
             "oscillates")  # fmt: skip
    return record | {
        "Kp": found.Kp,
        "Ki": found.Ki,
        "units": GAIN_UNITS,
        **{n: getattr(j, n) for n in names},
        "limits_broken_in_this_step": list(j.broken),
        "limits_broken_on_the_revised_plant": list(side.broken),
    }
