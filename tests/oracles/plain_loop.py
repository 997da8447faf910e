"""A closed loop in plain Python: the equations written out once more, apart from the project's modules.

The one thing taken over is the form of the regulator's step, which `tests/laws/test_regulator.py`
holds against the closed form of its law.
"""

from math import exp

DT = 0.001


class Plant:
    """Regulator, hysteresis and lag in series, with their own state; parameters by name."""

    def __init__(self, p, P=None, h=0.0, virgin=True):
        self.p, self.P, self.h, self.y, self.virgin = p, p["rest_pressure"] if P is None else P, h, h, virgin

    def move(self, v):
        p = self.p
        e = p["gain"] * v - self.P
        w = e * e / (e * e + p["e0"] ** 2)
        slow, fast = p["k_slow"] * DT, p["k_fast"] * DT
        share = (1 - w) * (1 - exp(-slow)) + w * (1 - exp(-fast))
        share -= w * (1 - w) * (fast - slow) * (slow + w * (fast - slow) - (fast - slow) / 2)
        before, self.P = self.P, self.P + share * e
        x, held = self.P - p["rest_pressure"], self.h
        if not self.virgin:
            self.h += p["s"] * (self.P - before)
        if self.h < p["a1"] * x - p["w1"]:
            self.h, self.virgin = p["a1"] * x - p["w1"], False
        if self.h > p["a2"] * x + p["w2"]:
            self.h, self.virgin = p["a2"] * x + p["w2"], False
        # y' = (h - y) / Tw with h on a straight line from `held` to h.
        rate, decay = (self.h - held) / DT, exp(-DT / p["Tw"])
        self.y = self.h - rate * p["Tw"] + (self.y - held + rate * p["Tw"]) * decay


def closed_loop(plant, Kp, Ki, reference, seconds, delay=0.0):
    """Angles and commands of a PI around a plant whose air takes `delay` seconds through its tube."""
    p = plant.p
    integral = plant.P - p["rest_pressure"]
    tube = [plant.P / p["gain"]] * round(delay / DT)
    angles, commands = [], []
    for _ in range(round(seconds / DT)):
        e = reference - plant.y
        wanted = (p["rest_pressure"] + Kp * e + integral) / p["gain"]
        v = min(max(wanted, 0.0), 4.0)
        if not ((wanted > 4.0 and e > 0.0) or (wanted < 0.0 and e < 0.0)):
            integral += Ki * e * DT
        angles.append(plant.y)
        commands.append(v)
        tube.append(v)
        plant.move(tube.pop(0))
    return angles, commands
