"""The loop of PI and wrist without offsets: linear in the branch's slope, but for the regulator's rate.

While the command is not clipped and the reference stands still, with

    x = (r - y [deg],  h - y [deg],  q = gain v - P [kPa]),

    dx/dt = a x + b(slope) k(q) q,     q = x[2],     k(q) between k_slow and k_fast,

whatever the pressure, the offsets of the lines and the memory: only the slope of the branch that the
wrist is on is left of the hysteresis.  In a dead zone the slope is 0 (`branch_slopes` leaves it out).
Sampled at 1 ms, by the laws that the simulator steps (`plants.actuator.regulator`, `plants.lag`),

    x+ = sampled_a x + sampled_b(slope) share q,      share between share_slow and share_fast.

Derivation: dy/dt = (h - y)/Tw; dh/dt = slope dP/dt; dP/dt = k(q) q; gain dv/dt = Kp d(r - y)/dt
+ Ki (r - y).  A sample within which a corner is passed has a slope between the two.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from design.controllers.pi import PI
from plants import lag
from plants.actuator import regulator
from plants.effects.effect import dead_time_of
from plants.linearisation import branch_slopes
from plants.wrist import SAMPLE_TIME, Wrist

Array = NDArray[np.float64]

STATES = ("r - y [deg]", "h - y [deg]", "gain v - P [kPa]")

FILTER = "a filter of the angle"


@dataclass(frozen=True)
class LoopModel:
    """A PI and a wrist as a switched loop of three states.

    Kp [kPa/deg], Ki [kPa/(deg s)] as they act on the plant; slopes [deg/kPa] by branch; k_slow, k_fast
    [1/s]; Tw [s]; dead_time [s]: of the plant's own tube, 0 for a declared wrist; left_out: effects of the
    plant that this model does not include, so that proofs do not cover the plant; dt: sample time [s]; weight
    [1]: of the reference, which the loop does not see but a
    step's start does; other_law: what the controller has, in words, that this model has not, so that nothing
    that is proved of it is proved of the loop.
    """

    Kp: float
    Ki: float
    slopes: dict[str, float]
    k_slow: float
    k_fast: float
    Tw: float
    dead_time: float = 0.0
    left_out: tuple[str, ...] = ()
    dt: float = SAMPLE_TIME
    weight: float = 1.0
    other_law: str = ""

    @classmethod
    def of(cls, wrist: Wrist, controller: PI) -> "LoopModel":
        """The model of a wrist under a PI, whose idea of the regulator's gain may be off.

        >>> from plants import Wrist
        >>> from design.controllers.pi import PI
        >>> LoopModel.of(Wrist.flexion(), PI(1.2, 2.2)).slopes
        {'transit': 0.0803, 'line1': 0.36, 'line2': 0.36}
        """
        ratio = float(wrist.regulator.gain / controller.gain)
        return cls(
            ratio * float(controller.Kp),
            ratio * float(controller.Ki),
            branch_slopes(wrist, wrist.reach),
            float(wrist.regulator.k_slow),
            float(wrist.regulator.k_fast),
            float(wrist.Tw),
            float(dead_time_of(wrist.effects)),
            tuple(e.NAME for e in wrist.effects if not e.only_delays),
            wrist.rig.sample_time,
            float(getattr(controller, "b", 1.0)),
            FILTER if float(getattr(controller, "Tf", 0.0)) > 0.0 else "",
        )

    @property
    def distinct_slopes(self) -> dict[str, float]:
        """The slopes without repetition, by the names of the branches that have them.

        >>> from plants import Wrist
        >>> from design.controllers.pi import PI
        >>> LoopModel.of(Wrist.flexion(), PI(1.2, 2.2)).distinct_slopes
        {'transit': 0.0803, 'line1 and line2': 0.36}
        """
        names: dict[float, list[str]] = {}
        for branch, slope in self.slopes.items():
            names.setdefault(slope, []).append(branch)
        return {" and ".join(of): slope for slope, of in names.items()}

    @property
    def a(self) -> Array:
        """Of dx/dt = a x + b k(q) q, shape (3, 3)."""
        T = self.Tw
        return np.array([[0.0, -1.0 / T, 0.0], [0.0, -1.0 / T, 0.0], [self.Ki, -self.Kp / T, 0.0]])

    def b(self, slope: float) -> Array:
        """Of the same, on a branch of a slope [deg/kPa], shape (3,)."""
        return np.array([0.0, slope, -1.0])

    def matrix(self, slope: float, rate: float) -> Array:
        """The linear loop dx/dt = matrix x on one branch at one rate [1/s], shape (3, 3)."""
        return self.a + rate * np.outer(self.b(slope), [0.0, 0.0, 1.0])

    def share(self, rate: float) -> float:
        """Share of q that a sample takes away at a rate [1/s]."""
        return float(-np.expm1(-rate * self.dt))

    def sampled_matrix(self, slope: float, rate: float) -> Array:
        """The sampled linear loop x+ = matrix x on one branch at one rate [1/s], shape (3, 3)."""
        dt = self.dt
        c, gone = lag.sampled(self.Tw, dt), self.share(rate)
        error = np.array([1.0, -(1.0 - c.keep), -c.after * slope * gone])
        ahead = np.array([0.0, c.keep, (1.0 - c.after) * slope * gone])
        lack = np.array([0.0, 0.0, 1.0 - gone])
        lack += self.Kp * (error - np.array([1.0, 0.0, 0.0])) + np.array([self.Ki * dt, 0.0, 0.0])
        return np.array([error, ahead, lack])

    def sampled_shares(self) -> tuple[float, float]:
        """Least and largest share of q that the simulator's regulator takes away in a sample: those of
        the two rates, with what its second-order term adds."""
        c = regulator.sampled(regulator.Regulator(1.0, self.k_fast, self.k_slow, 1.0), self.dt)
        shares = regulator.share(np.append(0.0, np.geomspace(1e-4, 1e6, 20_001)), c)
        return float(np.min(shares)), float(np.max(shares))
