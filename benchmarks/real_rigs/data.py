"""Other people's measured data as campaigns: what each column is taken for, and what is assumed.

The data stay where they are: `WRIST_DATA` names the folder, the campaigns made of them go to
``build/real``, and neither is part of the project.
"""

import csv
import hashlib
import io
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from plants.files import write_atomically

Array = NDArray[np.float64]
Columns = Mapping[str, Array]
DEGREES = 180.0 / np.pi

VOLTS_FULL = 4.0
FULL_SETPOINT = 255.0
"""Largest set-point of the slow staircases [kPa], which is taken for the full command."""

GAIN = 49.4
"""Declared gain of the regulator [kPa/V]: what a set-point of the fast steps is divided by."""

ACTION = 0.065
"""Change of the desired muscle pressure, of its full range, for an action of 1."""

THIRD = 3
"""Every so many episodes one is held out."""


@dataclass(frozen=True)
class Rig:
    """A campaign to be made of measured data.

    name: of the campaign and its axis; title: for people; folder: within the data; origin:
    repository @ commit and path; licence; sources: files within the folder, those to fit on and
    those held out; sample_time [s]; stage: the last one measured; mapping: what was done to the
    columns; assumed: what nobody recorded; read: the standard columns of one file.
    """

    name: str
    title: str
    folder: str
    origin: str
    licence: str
    fit: tuple[str, ...]
    validate: tuple[str, ...]
    sample_time: float
    stage: str
    mapping: tuple[str, ...]
    assumed: tuple[str, ...]
    read: Callable[[Path], Columns]

    @property
    def sources(self) -> tuple[str, ...]:
        """Files within the folder of the data."""
        return self.fit + self.validate


def rigs(data: Path) -> tuple[Rig, ...]:
    """The campaigns that can be made of a folder of data, the smallest first."""
    episodes = sorted(p.name for p in (data / "pam-arm").glob("*.json"))
    return (_SWEEPS, _RESPONSES, _joint(0, 0, 1, episodes), _joint(3, 6, 2, episodes))


def convert(rig: Rig, data: Path, out: Path) -> Path:
    """Make the campaign of a rig in a folder of its own within `out`."""
    place = out / rig.name
    for source in rig.sources:
        write_atomically(place / _csv_name(source), _csv_text(rig.read(data / rig.folder / source)))
    stage = 'stage = "regulator"\n' if rig.stage == "regulator" else ""
    fit, validate = (json.dumps([_csv_name(n) for n in names]) for names in (rig.fit, rig.validate))
    write_atomically(
        place / "campaign.toml",
        f'axis = "{rig.name}"\n{stage}start = "unknown"\nsample_time_s = {rig.sample_time}\n'
        f"fit = {fit}\nvalidate = {validate}\n",
    )
    return place


def checksums(rig: Rig, data: Path) -> dict[str, str]:
    """SHA-256 of the files that a campaign is made of, by name."""
    return {n: hashlib.sha256((data / rig.folder / n).read_bytes()).hexdigest() for n in rig.sources}


def _csv_name(source: str) -> str:
    return Path(source).stem + ".csv"


def _csv_text(columns: Columns) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([f"{v:.7g}" for v in row] for row in zip(*columns.values(), strict=True))
    return text.getvalue()


def _table(path: Path) -> dict[str, Array]:
    with path.open(encoding="utf-8", newline="") as file:
        heading, *rows = csv.reader(file)
    values = np.array(rows, float)
    return {name: values[:, i] for i, name in enumerate(heading)}


def _steps(path: Path) -> Columns:
    t = _table(path)
    return {
        "time_s": t["Time"], "command_V": t["Target"] / GAIN, "pressure_kPa": t["Pressure"],
        "pwm": t["PWM"],
    }  # fmt: skip


def _staircase(path: Path) -> Columns:
    t = _table(path)
    return {
        "time_s": t["Timestamp_s"], "command_V": t["Setpoint_kPa"] * (VOLTS_FULL / FULL_SETPOINT),
        "pressure_kPa": t["Feedback_kPa"], "pwm_main": t["PWM_Main"], "pwm_aux": t["PWM_Aux"],
    }  # fmt: skip


def desired(first: Array, action: Array) -> Array:
    """Desired pressures (n, muscles), 0 to 1, of actions that change them, from `first` (muscles,)."""
    found = np.empty_like(action)
    now = np.clip(first, 0.0, 1.0)
    for i, change in enumerate(action):
        now = np.clip(now + ACTION * change, 0.0, 1.0)
        found[i] = now
    return found


def _episode(path: Path, joint: int, muscle: int, neighbour: int) -> Columns:
    """One joint of an episode; the muscle that raises the angle, then its antagonist, are `muscle` and
    the next; `neighbour` is the joint that counts as the other motion."""
    content = json.loads(path.read_text(encoding="utf-8"))
    rows = slice(1, len(content["ob"]) - 1)  # the last action may stand beside no observation
    ob, action = np.array(content["ob"], float)[rows], np.array(content["action"], float)[rows]
    pressures = ob[:, 8:16]
    wanted = desired(pressures[0], action)
    differential = pressures[:, 0::2] - pressures[:, 1::2]
    found = {
        "time_s": 0.01 * np.arange(len(ob)),
        "command_V": 0.5 * VOLTS_FULL * (1.0 + wanted[:, muscle] - wanted[:, muscle + 1]),
        "angle_deg": DEGREES * ob[:, joint],
        "pressure_kPa": 100.0 * (1.0 + differential[:, joint]),
        "other_pressure_kPa": 100.0 * (1.0 + differential[:, neighbour]),
        "co_contraction": 0.5 * (pressures[:, muscle] + pressures[:, muscle + 1]),
    }
    others = [j for j in range(4) if j not in (joint, neighbour)]
    return found | {f"joint_{j}_pressure_kPa": 100.0 * (1.0 + differential[:, j]) for j in others}


def _joint(joint: int, muscle: int, neighbour: int, episodes: Sequence[str]) -> Rig:
    held_out = tuple(episodes[THIRD - 1 :: THIRD])
    return Rig(
        f"pam-joint-{joint}",
        f"Joint {joint} of an arm of pneumatic muscles",
        "pam-arm",
        "ALRhub/action-conditional-rkn @ 7a8ae18c17ff3f324f58a6d2ef8ee93265a6fa07, data/PAMData/Data2/",
        "MIT",
        tuple(e for e in episodes if e not in held_out),
        held_out,
        0.01,
        "wrist",
        (
            f"pressure_kPa = 100 (1 + p{muscle} - p{muscle + 1}) of the measured pressures, which are parts "
            "of full scale: 100 where they are equal, and 1 kPa is a hundredth of full scale",
            f"command_V = 2 (1 + p{muscle} - p{muscle + 1}) of the desired pressures",
            f"other_pressure_kPa: the same of the pair of joint {neighbour}; the other pairs, and the mean "
            "pressure of this pair (co_contraction), as further channels",
            "first and last row of each episode dropped; angle from rad",
        ),
        (
            "no time was logged: the nominal 100 Hz (a ball's flight says 10.5 to 10.8 ms)",
            "the set-point was not logged: clip(previous + 0.065 action, 0, 1), from the first measured "
            "pressure",
            "the angle is zero where both pressures are equal",
        ),
        lambda path: _episode(path, joint, muscle, neighbour),
    )


_PUMP = (
    "pressure-loop",
    "DiegoSanMo6011/softbot_pneumatic_driver @ a7194441138d65f9936e689092c17a541618874c, "
    "softbot/experiments/2026-01/",
    "MIT",
)
_SWEEPS = Rig(
    "pressure-loop-steps",
    "A small pump: one step, at eight settings of its loop",
    *_PUMP,
    ("sweep_kp_10.csv", "sweep_kp_15.csv", "sweep_kp_25.csv", "sweep_ki_300.csv", "sweep_ki_800.csv"),
    ("sweep_kp_20.csv", "sweep_kp_30.csv", "sweep_ki_500.csv"),
    0.02,
    "regulator",
    ("command_V = set-point / 49.4 kPa/V", "duty of the pump (PWM) as a further channel"),
    ("files of different loop gains are taken for one rig",),
    _steps,
)
_RESPONSES = Rig(
    "pressure-loop-staircases",
    "A small pump: staircases, to set-points out of its reach",
    *_PUMP,
    ("sweep_response_20260121_165923.csv",),
    ("sweep_response_20260121_165542.csv",),
    0.05,
    "regulator",
    ("command_V = set-point x 4 V / 255 kPa", "duties of both pumps (PWM) as further channels"),
    (),
    _staircase,
)
