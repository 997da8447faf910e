"""Campaigns of what gives the pressure, without a joint."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd

from tests.rig.signals import Signal

ROW = 0.01
"""Time between rows [s]."""

LEVELS = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 0.7, 0.4, 0.2, 0.5, 0.9, 0.3, 0.1, 0.0)
"""Of the staircase, as shares of the range."""


def write_pressures(folder: Path, pressure: Callable[[Signal], Signal], most: float, noise: float) -> None:
    """Levels that are held, a sine and random levels to fit on, and random levels held out, of commands
    from 0 to `most` [V], with the pressure [kPa] that each makes and white noise [kPa]."""
    rng, time = np.random.default_rng(3), np.arange(0.0, 40.0, ROW)
    commands = {
        "stairs": np.repeat(most * np.array(LEVELS), round(3.0 / ROW)),
        "sine": most * (0.47 - 0.42 * np.cos(2.0 * np.pi * 0.3 * time)),
        "steps": np.repeat(most * rng.uniform(0.05, 0.95, 24), round(2.0 / ROW)),
        "check": np.repeat(most * rng.uniform(0.05, 0.95, 24), round(1.7 / ROW)),
    }
    folder.mkdir(parents=True, exist_ok=True)
    for name, command in commands.items():
        pd.DataFrame(
            {
                "time_s": np.round(ROW * np.arange(len(command)), 4),
                "command_V": np.round(command, 4),
                "pressure_kPa": np.round(pressure(command) + rng.normal(0.0, noise, len(command)), 2),
            }
        ).to_csv(folder / f"{name}.csv", index=False, lineterminator="\n")
    (folder / "campaign.toml").write_text(
        f'axis = "valve"\nstage = "regulator"\nstart = "unknown"\nsample_time_s = {ROW}\n'
        'fit = ["stairs.csv", "sine.csv", "steps.csv"]\nvalidate = ["check.csv"]\n'
    )
