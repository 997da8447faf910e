"""One turn of the circle: a design for a plant, its loop on the rig, and the check of the log."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

import design
import plants
from plants.measured.campaigns.campaign import Campaign
from tests.rig.campaign import logged_table
from tests.rig.core import TICK, Controller
from tests.rig.rig import Rig

TIME = TICK * np.arange(20_001)
REFERENCE = np.select([TIME < 1.0, TIME < 7.0, TIME < 12.0], [0.0, 15.0, 0.0], -15.0)
"""15 deg, back, and 15 deg the other way."""


@dataclass(frozen=True)
class Turn:
    """The error of the model [deg] on held-out data, its PI, what the rig's true angle did, and the check."""

    model_error: float
    Kp: float
    Ki: float
    angle: np.ndarray
    check: str
    said: str

    @property
    def overshoot_percent(self) -> float:
        """Of the step, the larger of both signs."""
        beyond = max(self.angle[TIME < 7.0].max() - 15.0, -15.0 - self.angle[TIME > 12.0].min(), 0.0)
        return 100.0 * beyond / 15.0

    @property
    def iae(self) -> float:
        """Integral of the absolute error [deg s] over the run."""
        return float(TICK * np.abs(REFERENCE - self.angle).sum())


def turn(rig: Rig, folder: Path, number: int, plant: plants.ParameterSet, model_error: float) -> Turn:
    """Tune a PI for all that a plant may be, run it on the rig, and check the log, which is kept in the
    folder as ``loopN.csv``."""
    from reports.check.words import title

    pi = design.tune_robustly(design.requirement(plant), design.Region(points=12), starts=0).final
    v, place = plant.values, folder / f"loop{number}.csv"
    run = rig.follow(REFERENCE, Controller(pi.Kp, pi.Ki, v["gain"], v["rest_pressure"]), number)
    logged_table(rig, "task", run, False).to_csv(place, index=False)
    checked = design.check_log(plants.load_recording(place, rig=plant.rig), plant, pi.controller)
    return Turn(model_error, pi.Kp, pi.Ki, run.angle, checked.verdict, title(checked))


def campaign(folder: Path, axis: str, *logs: str) -> Campaign:
    """The campaign of two recordings in open loop and some of the closed one; ``sine`` is held out."""
    fit = ", ".join(f'"{name}.csv"' for name in ("staircase", "steps", *logs))
    text = f'axis = "{axis}"\nsample_time_s = 0.01\nfit = [{fit}]\nvalidate = ["sine.csv"]\n'
    (folder / "campaign.toml").write_text(text)
    return plants.load_campaign(folder)
