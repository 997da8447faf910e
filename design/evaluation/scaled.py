"""Metrics of steps of any size, scaled to the step of a rig's task."""

from typing import Any

import numpy as np

from design.evaluation.metrics import Metrics

Number = Any

SMALLEST = 1.0 / 3.0
"""What is judged relative to a step is so to one of at least this share of the task's: a reference that is
changed just as the wrist passes it would make any overshoot a large share of a tiny step."""


def scaled(m: Metrics, size: Number, task: float) -> dict[str, Number]:
    """What limits and cost are held against, by name, of steps of sizes [deg], where a rig's task is a step
    of `task` [deg].

    A step of the rig's task is what the limits and the tuning set are made for, so others are scaled to it:
    overshoot in percent of the step, of one of `SMALLEST` at least; steady error in percent of the task's
    step, since how exactly an angle is held is a matter of degrees; total variation of the command of a
    larger step as if scaled down to it (a smaller one must travel for the play of the loop all the same, and
    is not scaled up); IAE and ITAE per degree of a step of `SMALLEST` at least, times that step.
    """
    smallest = SMALLEST * task
    least = np.maximum(size, smallest)
    return {
        "overshoot_percent": np.nan_to_num(m.overshoot_percent * np.minimum(size / smallest, 1.0)),
        "steady_error_percent": 100.0 * m.steady_state_error_deg / task,
        "total_variation_V": m.total_variation_V * np.minimum(task / least, 1.0),
        "iae_deg_s": m.iae_deg_s * task / least,
        "itae_deg_s2": m.itae_deg_s2 * task / least,
        "settling_time_s": m.settling_time_s,
    }
