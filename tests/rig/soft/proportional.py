"""A proportional regulator of second order, which gives nothing below a least command.

The pressure is that of `scipy.signal`: a second-order system, the command held over each sample;
the library has no part in it.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.signal import cont2discrete, lfilter

from tests.rig.signals import Signal

ROW = 0.01


@dataclass(frozen=True)
class Proportional:
    """Pressure = gain (command - dead) above a dead command [V], and none below; natural frequency [rad/s],
    damping ratio, delay [s] and noise [kPa]."""

    gain: float = 20.0
    dead: float = 0.0
    natural: float = 22.0
    damping: float = 0.8
    delay: float = 0.03
    noise: float = 0.25

    def pressure(self, command: Signal) -> Signal:
        """Pressure [kPa] at each row of a command [V] that was held at its first value for long."""
        late = round(self.delay / ROW)
        asked = np.concatenate([np.full(late, command[0]), command])[: len(command)]
        target = self.gain * np.maximum(asked - self.dead, 0.0)
        continuous = ([self.natural**2], [1.0, 2.0 * self.damping * self.natural, self.natural**2])
        numerator, denominator, _ = cont2discrete(continuous, ROW, "zoh")
        return np.asarray(target[0] + lfilter(numerator.ravel(), denominator, target - target[0]))

    def write(self, folder: Path) -> None:
        """A campaign of pressures: levels, a sine and random levels to fit on, and random levels held out."""
        rng, levels = np.random.default_rng(3), [0, 2, 4, 6, 8, 10, 7, 4, 2, 5, 9, 3, 1, 0]
        time = np.arange(0.0, 40.0, ROW)
        commands = {
            "stairs": np.repeat(np.array(levels, float), round(3.0 / ROW)),
            "sine": 4.7 - 4.2 * np.cos(2.0 * np.pi * 0.3 * time),
            "steps": np.repeat(rng.uniform(0.5, 9.5, 24), round(2.0 / ROW)),
            "check": np.repeat(rng.uniform(0.5, 9.5, 24), round(1.7 / ROW)),
        }
        folder.mkdir(parents=True, exist_ok=True)
        for name, command in commands.items():
            pressure = self.pressure(command) + rng.normal(0.0, self.noise, len(command))
            pd.DataFrame(
                {
                    "time_s": np.round(ROW * np.arange(len(command)), 4),
                    "command_V": np.round(command, 4),
                    "pressure_kPa": np.round(pressure, 2),
                }
            ).to_csv(folder / f"{name}.csv", index=False, lineterminator="\n")
        (folder / "campaign.toml").write_text(
            f'axis = "valve"\nstage = "regulator"\nstart = "unknown"\nsample_time_s = {ROW}\n'
            'fit = ["stairs.csv", "sine.csv", "steps.csv"]\nvalidate = ["check.csv"]\n'
        )
