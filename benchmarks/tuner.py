"""The tuner: from a slider that moves to the picture that Jupyter is given, through the widget's callback."""

import time
from itertools import chain

import numpy as np

from design.tuner.setting import Slider
from design.tuner.widget import Tuner

BUDGET_MS = 100.0
DRAG = 60
"""Positions of a drag from one end of a slider to the other and back."""

MEANING = {
    "tuner.callback_p95_share_of_100_ms": "95th percentile of a drag, gains or plant, the larger / 100 ms",
    "tuner.gains_p50_ms": "ms, from Kp or Ki moved to the picture sent, median",
    "tuner.gains_p95_ms": "ms, the same, 95th percentile",
    "tuner.gains_max_ms": "ms, the same, the longest",
    "tuner.plant_p50_ms": "ms, from width, slopes or dead time moved to picture and map sent, median",
    "tuner.plant_p95_ms": "ms, the same, 95th percentile",
    "tuner.plant_max_ms": "ms, the same, the longest",
    "tuner.plant_map_in_time": "share of those positions whose coarse map was ready at once",
    "tuner.sharpen_max_ms": "ms, the longest that a drag waits for the map being sharpened",
}
"""What each figure says."""


def drag(tuner: Tuner, slider: Slider) -> list[tuple[float, bool]]:
    """Of each position of a drag over a slider and back: milliseconds, and whether the map was ready."""
    before = getattr(tuner, slider.name)
    space = np.geomspace if slider.logarithmic else np.linspace
    there = space(slider.low, slider.high, DRAG // 2)
    taken = []
    for value in chain(there, there[-2::-1]):
        shown = tuner.picture
        begin = time.perf_counter()
        setattr(tuner, slider.name, float(value))
        taken.append((1e3 * (time.perf_counter() - begin), not tuner.regions["behind"]))
        assert tuner.picture is not shown or float(value) == before
    setattr(tuner, slider.name, before)
    return taken


def sharpen(tuner: Tuner) -> list[float]:
    """Milliseconds of each piece of the map until it is complete."""
    taken = []
    while not tuner.regions["complete"]:
        begin = time.perf_counter()
        tuner.sharpen += 1
        taken.append(1e3 * (time.perf_counter() - begin))
    return taken


def measure() -> dict[str, float | None]:
    """Figures over both motions, with 20 ms of dead time where its slider is not the one that moves."""
    moves: dict[str, list[tuple[float, bool]]] = {"gains": [], "plant": []}
    pieces: list[float] = []
    for axis in ("flexion", "deviation"):
        tuner = Tuner(axis)
        tuner.dead_time = 0.02
        for slider in tuner.sliders:
            moves["gains" if slider.name in ("Kp", "Ki") else "plant"] += drag(tuner, slider)
        pieces += sharpen(tuner)
    taken = {kind: [ms for ms, _ in those] for kind, those in moves.items()}
    figures: dict[str, float | None] = {}
    for kind in ("gains", "plant"):
        for name, share in (("p50", 50), ("p95", 95), ("max", 100)):
            figures[f"tuner.{kind}_{name}_ms"] = float(np.percentile(taken[kind], share))
    worst = max(float(np.percentile(taken[kind], 95)) for kind in ("gains", "plant"))
    figures["tuner.plant_map_in_time"] = float(np.mean([ready for _, ready in moves["plant"]]))
    figures["tuner.sharpen_max_ms"] = max(pieces)
    return {"tuner.callback_p95_share_of_100_ms": worst / BUDGET_MS, **figures}
