"""``python -m benchmarks.section_7_2``: the paper's own residual, reconstructed.

Section 7.2 of the paper: on radial/ulnar deviation there are errors "at about 6 sec between the experimental
results and the simulation results", blamed on the straight lines that it drew through a curved loop.  No
measured curve survives, so the argument is rebuilt: a deviation rig of ``tests/rig`` with curved branches,
under the stand-in PI, beside the same rig with straight branches, which is the paper's model.  When does the
one depart from the other, for which curvature is that at about 6 s, and does the trace name it?

A reconstruction: the rig's parameters, the gains and the form of the curvature are assumed.
"""

import sys
import tempfile
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from plants.measured.campaigns.campaign import load_campaign
from plants.measured.trace.result import Trace
from plants.measured.trace.trace import trace_campaign
from reports.shared.figures.style import BLACK, BLUE, DASHED, DOTTED, GREY, VERMILLION, WIDTH, styled
from tests.rig.campaign import TASK_CONTROLLER, record
from tests.rig.effects import Hidden
from tests.rig.parameters import NOMINAL
from tests.rig.rig import Noise, Rig
from tests.rig.wrist_effects import Curvature

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
STEPS = (15.0, -15.0)
KNEES = (45.0, 60.0, 75.0, 90.0, 105.0, 120.0, 150.0)
"""Pressures [kPa] from rest at which the branches of a saturating actuator bend: less is more curved."""

CUBICS = (-0.25, -0.15, 0.15, 0.25)
"""Cubic curvature, relative to the straight slope at the ends of the range."""

DRAWN, TRACED = 15.0, -15.0
"""Step that is drawn, and the one whose knee the traced rig has: the milder of the two."""

PAPER = 6.0
"""Time [s] at which the paper sees experiment and simulation differ."""

NOISE = Noise(0.06, 0.25)


class Departure(NamedTuple):
    """How far a curved rig departs from the straight one in a step: the form of the curvature, its strength
    and unit, the step [deg], the largest difference of the angles [deg] and its time [s]."""

    form: str
    strength: float
    unit: str
    step: float
    largest: float
    at: float


@dataclass(frozen=True)
class Reconstruction:
    """Departures of all curvatures; nearest: knee [kPa] with which a step departs most nearest to the paper's
    time, and that time [s], by step; responses (time, straight, curved) of the step that is drawn, at its
    knee; the trace of a rig with the knee of the other."""

    departures: tuple[Departure, ...]
    nearest: dict[float, tuple[float, float]]
    responses: tuple[Array, Array, Array]
    trace: Trace


def rig(curvature: Curvature, noise: Noise = NOISE) -> Rig:
    """The nominal deviation rig with curved branches."""
    return Rig(
        "deviation", ("branch-curvature",), noise, 72, NOMINAL["deviation"], Hidden(curvature=curvature)
    )


def response(curvature: Curvature, step: float) -> Array:
    """Angle [deg] at 1 kHz of a step from rest under the stand-in PI, without noise."""
    quiet = rig(curvature, Noise(0.0, 0.0))
    gains = TASK_CONTROLLER
    found: Array = quiet.closed_loop(gains.Kp, gains.Ki, step).run.angle
    return found


def departure(curvature: Curvature, step: float) -> tuple[float, float]:
    """Largest difference [deg] between the curved and the straight rig in a step, and its time [s]."""
    apart = np.abs(response(curvature, step) - response(Curvature(), step))
    k = int(np.argmax(apart))
    return float(apart[k]), 1e-3 * k


def nearest(step: float, time: float = PAPER) -> tuple[float, float]:
    """Knee [kPa], and the time [s] of its largest departure, that comes nearest to a time.

    The more curved, the later; so curved that the angle is never reached, the largest is the last.
    """
    tried = [(float(k), departure(Curvature(2, knee=float(k)), step)[1]) for k in np.arange(45.0, 160.0)]
    return min(tried, key=lambda found: abs(found[1] - time))


def departures() -> tuple[Departure, ...]:
    """Every curvature, in both steps."""
    made = [("saturating", k, "kPa", Curvature(2, knee=k)) for k in KNEES]
    made += [("cubic", c, "1", Curvature(1, cubic=c)) for c in CUBICS]
    return tuple(
        Departure(form, strength, unit, step, *departure(curve, step))
        for form, strength, unit, curve in made
        for step in STEPS
    )


def reconstruct() -> Reconstruction:
    """All of it; the trace takes a minute."""
    found = {step: nearest(step) for step in STEPS}
    drawn = Curvature(2, knee=found[DRAWN][0])
    curved, straight = response(drawn, DRAWN), response(Curvature(), DRAWN)
    time = 1e-3 * np.arange(len(curved))
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        record(rig(Curvature(2, knee=found[TRACED][0])), folder)
        trace = trace_campaign(load_campaign(folder))
    return Reconstruction(departures(), found, (time, straight, curved), trace)


def lines(found: Reconstruction) -> Sequence[str]:
    """What came of it, in lines."""
    table = [
        f"{d.form:>10} {d.strength:7.4g} {d.unit:3} step {d.step:+.0f} deg: "
        f"{d.largest:5.2f} deg at {d.at:.2f} s"
        for d in found.departures
    ]
    knees = [
        f"nearest to {PAPER:g} s in a step of {s:+.0f} deg: {t:.2f} s, with a knee of {k:.0f} kPa"
        for s, (k, t) in found.nearest.items()
    ]
    t = found.trace
    named = ", ".join(e.name for e in t.effects) or "nothing"
    return [
        *table, *knees,
        f"the trace: {t.verdict}, {named}; angle error {t.before['angle_deg']:.3g} -> "
        f"{t.after['angle_deg']:.3g} deg on held-out recordings, noise {t.noise['angle_deg']:.3g} deg",
    ]  # fmt: skip


def draw_departure(found: Reconstruction) -> "Figure":
    """Both responses of the traced step, and their difference, which is largest at the paper's time."""
    time, straight, curved = found.responses
    with styled():
        from matplotlib.figure import Figure

        figure = Figure(figsize=(WIDTH, 4.2), layout="constrained")
        top, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        top.plot(
            time, straight, color=VERMILLION, linestyle=DASHED, label="straight branches (the paper's model)"
        )
        top.plot(time, curved, color=BLUE, label=f"curved branches, knee {found.nearest[DRAWN][0]:.0f} kPa")
        top.axhline(DRAWN, color=GREY, linewidth=0.7)
        top.set(ylabel="Angle [deg]", title=f"Deviation, step to {DRAWN:g} deg under the stand-in PI")
        top.legend(loc="best")
        below.plot(time, curved - straight, color=BLACK)
        below.axvline(PAPER, color=GREY, linestyle=DOTTED)
        below.annotate("about 6 s", (PAPER, 0.0), xytext=(4, 4), textcoords="offset points")
        below.set(xlabel="Time [s]", ylabel="Difference [deg]", xlim=(time[0], time[-1]))
    return figure


if __name__ == "__main__":
    print(*lines(reconstruct()), sep="\n")
    sys.exit(0)
