"""Wrists with effects stepped in plain Python, sample by sample, as their laws are written."""

from itertools import pairwise

import numpy as np

from plants import Wrist
from plants.dynamics import bend, read, step
from plants.effects.effect import Around

DT = 0.001
WRIST = Wrist.flexion()
ONE_RATE = WRIST.with_values(k_slow=5.0, k_fast=5.0)
"""A regulator that is a first-order lag of 0.2 s."""


def played(wrist, commands, state=None, other=0.0):
    """Pressures, angles and readings, (n + 1,) each, of a wrist under commands [V]."""
    c, s = wrist.sampled(), wrist.rest() if state is None else state
    rows = [(s.pressure, s.angle, read(s, c, Around(0.0, other)))]
    for k, v in enumerate(commands):
        s = step(s, v, c, Around(k * DT, other))
        rows.append((s.pressure, s.angle, read(s, c, Around((k + 1) * DT, other))))
    return np.array(rows, float).T


def moved(wrist, pressures, other=0.0, state=None):
    """Loop angles and joint angles, (n,) each, of a wrist whose pressure [kPa] takes given values."""
    c, s = wrist.sampled(), wrist.rest() if state is None else state
    rows = [(s.memory.h, s.angle)]
    for k, (_, after) in enumerate(pairwise(pressures)):
        s = bend(s, after, s.effects, c, Around(k * DT, other))
        rows.append((s.memory.h, s.angle))
    return np.array(rows, float).T


def ramp(*corners, rate=100.0):
    """Pressures [kPa] from corner to corner at a rate [kPa/s]."""
    parts = [np.linspace(a, b, round(abs(b - a) / rate / DT) + 1)[1:] for a, b in pairwise(corners)]
    return np.concatenate([[corners[0]], *parts])
