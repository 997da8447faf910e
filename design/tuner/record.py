"""Pictures and maps as what JSON holds, numbers in words where they are read: what the browser is sent."""

from collections.abc import Mapping
from math import floor, isfinite, log10
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from design.synthesis.requirements import Limits
from design.synthesis.tuning import Region
from design.tuner.branch_margins import BranchMargins
from design.tuner.picture import LimitReading, Picture, ShownStep, shown_samples
from design.tuner.regions import Regions, outline
from design.tuner.setting import Slider
from plants.hysteresis import Role
from plants.parameters.quantities import in_units
from plants.rig import Rig
from plants.wrist import Wrist

Array = NDArray[np.float64]


class Words(NamedTuple):
    """How a limited quantity is told: its name, its unit, the factor to that unit, and which side is good."""

    label: str
    unit: str = ""
    per_unit: float = 1.0
    sign: str = "≤"


LIMITS: Mapping[str, Words] = {
    "overshoot_percent": Words("Overshoot", " %"),
    "Ms": Words("Ms, peak of the sensitivity"),
    "delay_margin_s": Words("Delay margin", " ms", 1000.0, "≥"),
    "total_variation_V": Words("Total variation of the command", " V"),
    "steady_error_percent": Words("Left at the end of the run", " %"),
    "Mt": Words("Mt, peak of the complementary sensitivity"),
    "settling_time_s": Words("Settled after", " s"),
    "WT": Words("|W T|, of the residual as unmodelled dynamics"),
}


PLAIN = Words("")


def words_of(name: str, rig: Rig) -> Words:
    """How a limited quantity of a rig is told, in its units."""
    words = LIMITS[name]
    return words._replace(unit=f" {rig.units.command}") if name == "total_variation_V" else words


def number(value: float, words: Words = PLAIN) -> str:
    """A value for reading.

    >>> number(0.0612, LIMITS["delay_margin_s"]), number(1924.0), number(float("inf"))
    ('61.2 ms', '1920', '∞')
    """
    return f"{float(f'{value * words.per_unit:.3g}'):g}{words.unit}" if isfinite(value) else "∞"


def about(
    title: str, sliders: tuple[Slider, ...], dead_time: float, limits: Limits, region: Region, rig: Rig
) -> dict[str, Any]:
    """What never changes while the tuner is shown; dead_time [s]: that of the user's own wrist."""
    return {
        "title": title,
        "dead_time_s": dead_time,
        "sliders": [s._asdict() for s in sliders],
        "limits": {n: w.label for n, w in LIMITS.items() if n in limits.named},
        "overshoot_percent": limits.overshoot_percent,
        "time_s": np.round(shown_samples(rig) * rig.sample_time, 9).tolist(),
        "duration_s": rig.task.duration,
        "step": rig.task.step,
        "command": list(rig.command_range),
        "units": dict(vars(rig.units)),
        "Kp": list(region.Kp),
        "Ki": list(region.Ki),
    }


def picture_record(shown: Picture, limits: Limits, plant: Wrist) -> dict[str, Any]:
    """A picture of a plant, its numbers rounded to what a screen shows."""
    rig = plant.rig
    settling = (
        f"{shown.settling_time_s:.3g} s" if isfinite(shown.settling_time_s) else f"> {rig.task.duration:g} s"
    )
    return {
        "plant": plant_words(plant),
        "trouble": shown.trouble,
        "note": shown.note,
        "series": [_series(s, rig) for s in shown.series],
        "limits": [_held(row, rig) for row in shown.limits],
        "margins": [_margins(row, limits) for row in shown.margins],
        "settling": settling,
        "iae": f"{number(shown.cost)} {rig.units.angle} s",
    }


def plant_words(plant: Wrist) -> dict[str, str]:
    """What the sliders of the loop make of its parameters, by slider.

    >>> plant_words(Wrist.flexion())["lines"]
    'a1 0.36, a2 0.36 deg/kPa'
    """
    values, law = plant.values, plant.hysteresis
    kinds, roles = law.kinds(values), law.roles(values)
    sliders: dict[str, Role] = {"width": "width", "lines": "outer", "transit": "inner"}
    return {
        slider: f"{', '.join(f'{n} {number(values[n])}' for n in roles[role])} "
        f"{in_units(kinds[roles[role][0]], plant.rig).unit}"
        for slider, role in sliders.items()
    }


def _rounded(values: Array, size: float) -> list[float]:
    """Values to a thousandth, of what is less than 1 in size to as many more places."""
    return [float(v) for v in np.round(values, 3 + max(0, -floor(log10(size))))]


def _series(s: ShownStep, rig: Rig) -> dict[str, Any]:
    task = s.case.task
    return {
        "memory": "return" if task.angle != 0.0 else task.start,
        "plus": task.reference > task.angle,
        "way": _rounded(s.way, rig.task.step),
        "command": _rounded(s.command, float(np.ptp(rig.command_range))),
    }


def _held(row: LimitReading, rig: Rig) -> dict[str, Any]:
    words = words_of(row.name, rig)
    lost = row.name in ("Ms", "delay_margin_s") and row.value in (float("inf"), 0.0)
    return {
        "name": row.name,
        "label": words.label,
        "value": "unstable" if lost else number(row.value, words),
        "limit": "none" if row.limit is None else f"{words.sign} {number(row.limit, words)}",
        "place": row.place.removesuffix(", nominal plant"),
        "broken": row.broken,
    }


def _margins(row: BranchMargins, limits: Limits) -> dict[str, Any]:
    """A row of the margins: cells of text, and whether a limit is broken there."""
    delay = LIMITS["delay_margin_s"]
    late = limits.delay_margin_s is not None and row.delay_margin_s < limits.delay_margin_s
    cells = [
        (number(row.Ms) if row.stable else "unstable", limits.Ms is not None and row.Ms > limits.Ms),
        (number(row.delay_margin_s, delay), late),
        (number(row.phase_margin_deg) + "°" if row.stable else "–", False),
        (number(row.gain_margin) if row.stable else "–", False),
    ]
    return {
        "branch": f"{row.branch}, {row.rate}",
        "cells": [{"text": text, "broken": broken} for text, broken in cells],
    }


def regions_record(known: Regions | None) -> dict[str, Any]:
    """A map as lines in the unit square; without one, as for a plant that is none, nothing."""
    if known is None:
        return {"level": 0, "complete": True, "behind": False, "held": [], "limits": {}, "best": None}
    drawn = outline(known)
    return {
        "level": known.level,
        "complete": known.complete,
        "behind": False,
        "held": [np.round(ring, 4).tolist() for ring in drawn.held],
        "limits": {n: [np.round(line, 4).tolist() for line in lines] for n, lines in drawn.limits.items()},
        "best": known.best,
    }
