"""Soft actuators with a name, each with its recordings."""

import numpy as np

from tests.rig.soft.chain import Switched
from tests.rig.soft.commands import sine, stairs, wandering
from tests.rig.soft.rig import Logger, SoftRig


def arm_a() -> SoftRig:
    """Driven by one slow sine; the pressure channel is renewed every 0.17 s."""
    return SoftRig(
        "arm-a", 0.0, 5.0, 30.0, 4.0, 0.66, 2.4, 1.6, 0.8, (0.0, 3.0, 8.0, 15.0, 25.0),
        (0.08, 0.05, 0.05, 0.04, 0.04), 10.0, 0.12, 30.0, 0.0, (0.08, 12.0), 0.08,
        Logger(0.0102, renewal=0.17, angle_noise=0.015, pressure_noise=0.15),
        {
            "large": lambda: sine(0.5, 4.5, 0.1, 60.0),
            "medium": lambda: sine(0.5, 3.5, 0.1, 60.0),
            "check": lambda: sine(0.5, 4.0, 0.1, 60.0),
        },
    )  # fmt: skip


def arm_b() -> SoftRig:
    """Three runs at 20 Hz, a sensor that rests at zero until the joint moves."""
    return SoftRig(
        "arm-b", 0.0, 10.0, 8.0, 0.0, 0.10, 4.0, 2.5, 0.3, (0.0, 2.0, 6.0, 12.0), (0.10, 0.08, 0.06, 0.05),
        12.0, 0.10, 18.0, 2.0, (0.05, 8.0), 0.15,
        Logger(0.05, angle_step=0.05, pressure_step=0.1, angle_noise=0.0, rests=True),
        {
            "stairs": lambda: stairs([0, 3, 6, 9, 10, 7, 4, 1, 5, 8, 2, 0], 5.0),
            "wave": lambda: sine(0.0, 10.0, 0.05, 80.0),
            "check": lambda: wandering(0.0, 10.0, 3.0, 60.0, 4),
        },
    )  # fmt: skip


def bender() -> SoftRig:
    """A bending actuator on a pump: filling in 2 s, exhausting in 5, commanded in counts of a DAC."""
    return SoftRig(
        "bender", 0.0, 4095.0, 0.02, 3.0, 0.08, 1.1, 0.45, 0.2, (0.0, 1.5, 4.0), (0.45, 0.2, 0.15), 8.0, 0.08,
        55.0, 0.0, (0.04, 6.0), 0.1,
        Logger(0.04, angle_step=0.1, pressure_step=0.05, angle_noise=0.1, pressure_noise=0.1, offset=0.3),
        {
            "stairs": lambda: stairs([0, 1000, 2000, 3000, 4000, 3000, 2000, 1000, 0], 10.0),
            "steps": lambda: wandering(0.0, 4095.0, 6.0, 90.0, 1),
            "wave": lambda: sine(0.0, 4000.0, 0.04, 75.0),
            "check": lambda: wandering(200.0, 3800.0, 5.0, 75.0, 2),
        },
    )  # fmt: skip


def finger() -> SoftRig:
    """A finger on a vacuum pump: on/off valves under pulse-width modulation at 40 Hz, in percent."""
    return SoftRig(
        "finger", 0.0, 100.0, 0.73, 0.0, 0.05, 1.0, 1.0, 0.0, (0.0, 1.0, 3.0, 7.0), (0.5, 0.2, 0.15, 0.1),
        0.0, 0.15, 80.0, 0.0, (0.08, 5.0), 0.1,
        Logger(0.01, angle_step=0.05, pressure_step=0.05, angle_noise=0.08, pressure_noise=0.1),
        {
            "stairs": lambda: stairs([0, 15, 30, 45, 60, 75, 90, 75, 60, 45, 30, 15, 0], 4.0),
            "steps": lambda: wandering(0.0, 95.0, 2.0, 70.0, 5),
            "wave": lambda: sine(0.0, 90.0, 0.15, 60.0),
            "check": lambda: wandering(5.0, 90.0, 1.5, 60.0, 6),
        },
        valves=Switched(150.0, 78.0, 220.0, 0.025),
    )  # fmt: skip


def climber() -> SoftRig:
    """Fitted on small steps and a slow sine, held out on large steps: what the rate far from the commanded
    pressure is, no recording to fit on says.  The pressure is renewed in every fortieth row."""
    return SoftRig(
        "climber", 0.0, 5.0, 40.0, 2.0, 0.05, 6.0, 5.0, 0.5, (0.0, 4.0, 12.0, 30.0), (0.06, 0.05, 0.05, 0.06),
        15.0, 0.10, 36.0, 0.0, (0.06, 5.0), 0.08,
        Logger(0.005, renewal=0.2, angle_noise=0.03, pressure_noise=0.1, pressure_step=0.25),
        {
            "stairs": lambda: stairs([0.2, 1, 1.8, 2.6, 3.4, 4.2, 4.2, 3.4, 2.6, 1.8, 1, 0.2], 5.0),
            "wave": lambda: sine(0.2, 4.0, 0.1, 60.0),
            "check": lambda: wandering(0.2, 4.2, 3.0, 60.0, 7),
        },
    )  # fmt: skip


def muscles() -> SoftRig:
    """A wrist of two pneumatic muscles behind electro-pneumatic regulators, made after figures that were read
    off a public log: pressure late by 53 ms, with 124 ms and a tail up to 0.9 s; a loop a third of the stroke
    wide, 9 / 18 deg at 200 kPa and 34 / 56 at 390 (up / down); the angle holds over 13 kPa, then jumps
    4 deg."""
    return SoftRig(
        "muscles", 0.0, 10.0, 60.0, 0.0, 0.053, 8.0, 8.0, 0.0, (0.0, 20.0, 45.0, 89.0),
        (0.010, 0.016, 0.056, 0.047), 95.0, -0.12, 65.0, 0.0, (0.06, 3.0), 0.06,
        Logger(0.01, angle_noise=0.03, pressure_noise=0.5, angle_step=0.01, pressure_step=0.15),
        {
            "sweep": lambda: np.concatenate([np.linspace(0, 10, 20000), np.linspace(10, 0, 20000)]),
            "stairs": lambda: stairs([0, 2, 4, 6, 8, 10, 7, 5, 3, 1, 6, 2, 0], 4.0),
            "steps": lambda: wandering(0.0, 9.0, 3.0, 60.0, 11),
            "check": lambda: wandering(0.0, 9.5, 2.5, 60.0, 12),
        },
        (0.12, 0.35), (2.5, 0.3),
    )  # fmt: skip


CAMPAIGNS = {
    "arm-a": (arm_a, ("large", "medium"), ("check",)),
    "arm-b": (arm_b, ("stairs", "wave"), ("check",)),
    "bender": (bender, ("stairs", "steps", "wave"), ("check",)),
    "finger": (finger, ("stairs", "steps", "wave"), ("check",)),
}
"""Rig, recordings to fit on and held-out ones, by name."""
