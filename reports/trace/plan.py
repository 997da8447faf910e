"""A planned recording in words, as a table, a record and a picture."""

from typing import TYPE_CHECKING, Any

import numpy as np

from plants.measured.trace.plan import PlannedRecording, chance
from reports.shared.figures.style import BLACK, GREY, new_figure, seen, styled
from reports.shared.tables import number

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def plan_lines(found: PlannedRecording) -> list[str]:
    """A plan for people: for each tie how well it distinguishes, beside a staircase of the same length."""
    said = [
        f"{r.name} or {r.other}: probability of a wrong decision {_percent(planned)}; with a staircase of "
        f"the same length {_percent(stairs)}"
        for r, planned, stairs in zip(found.rivals, found.planned, found.staircase_distance, strict=True)
    ] or ["no effects to distinguish; this recording has the most information on the parameters"]
    said.append(
        f"standard errors fall by a factor of {number(found.gain)}; with a staircase by "
        f"{number(found.staircase_gain)}"
    )
    return said


def plan_record(found: PlannedRecording, axis: str) -> dict[str, Any]:
    """A plan for machines."""
    return {
        "axis": axis,
        "ties": [
            {
                "effects": [r.name, r.other], "distance_noise": planned, "staircase_distance_noise": stairs,
                "chance_wrong": chance(planned), "staircase_chance_wrong": chance(stairs),
            }
            for r, planned, stairs in zip(found.rivals, found.planned, found.staircase_distance, strict=True)
        ],
        "errors_shrink": found.gain, "staircase_errors_shrink": found.staircase_gain,
        "candidates": found.candidates,
    }  # fmt: skip


def plan_table(found: PlannedRecording) -> str:
    """Time and command at the rows of a log, as CSV."""
    rows = [f"{t:.4f},{v:.4f}" for t, v in zip(*_rows(found), strict=True)]
    return "\n".join(["time_s,command_V", *rows]) + "\n"


def draw_plan(found: PlannedRecording) -> "Figure":
    """The command, and a staircase of the same length."""
    with styled():
        figure, (at,) = new_figure(height=2.6)
        time = np.arange(len(found.command)) * found.rig.sample_time
        few = seen(len(time))
        at.plot(time[few], found.staircase[few], color=GREY, lw=0.9, ls="--", label="staircase")
        at.plot(time[few], found.command[few], color=BLACK, lw=1.0, label="planned")
        at.set(xlabel="time [s]", ylabel="command [V]", xlim=(0.0, time[-1]))
        at.legend()
    return figure


def _rows(found: PlannedRecording) -> tuple[Any, Any]:
    every = round(found.rig.log_time / found.rig.sample_time)
    return np.arange(len(found.command))[::every] * found.rig.sample_time, found.command[::every]


def _percent(distance: float) -> str:
    wrong = 100.0 * chance(distance)
    return "below 0.01 %" if wrong < 0.01 else f"{number(wrong, 2)} %"
