"""From where the pressure is counted: the sensor's zero beside the pressure that a command of zero asks for.

A rig may log absolute pressures, or a pump may begin at some count of its DAC.  The regulator's law has no
such offset, so the pressure is counted from where the law's is zero.  How fast the regulator fills and
exhausts decides where it would come to rest, and a recording starts as far from rest as the zero says: so
the zero is fitted together with the regulator.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plants.effects.regulator.dead_time import DeadTime
from plants.effects.regulator.fill_exhaust import PressureDependentRates
from plants.effects.regulator.leak import SealedLeak
from plants.effects.regulator.regulator_curvature import Hyperbola
from plants.effects.regulator.regulator_deadband import LeastPressure
from plants.measured.campaigns.begin import Begin, first_rows
from plants.measured.campaigns.campaign import Campaign
from plants.measured.campaigns.playback import Playback
from plants.measured.fitting.estimate import corner_of, minimise, uncertainty
from plants.measured.fitting.problem import FitProblem
from plants.measured.fitting.stage import Stage
from plants.measured.guess.rig import guessed_set
from plants.measured.guess.rough_models import first_order, level_below, recorded
from plants.measured.instrument.logger import counted_from
from plants.measured.instrument.remark import Remark
from plants.measured.instrument.single_sine import only_sines
from plants.measured.residual.stillness import noise_of_campaign
from plants.measured.trace.stages.model import Model
from plants.rig import Zero

Array = NDArray[np.float64]
WORTH = 0.003
"""Share of the pressure's range by which the zeros must differ: less is within what a regulator leaves."""

BELOW = 0.1
"""Share of the range by which no pressure may lie below what the lowest command asks for: else the line is
bent, as by a supply that gives no more, and says nothing of its zero."""

FLAT = 0.8
"""Share of the mean square below which a pressure is taken to be level under the smallest commands."""

BENT = 0.7
"""Share of the mean square below which the pressure is taken to be a curve over the command."""

CERTAIN = 3.0
"""Times its standard error that the zero has to be off."""


@dataclass(frozen=True)
class FromZero:
    """What a fit of the regulator minimises where the sensor's zero is open, for
    `plants.measured.fitting.estimate`: vectors are those of `problem`, then the pressure [kPa] that is
    measured where the law's is zero."""

    problem: FitProblem

    @property
    def blocks(self) -> NDArray[np.intp]:
        """Blocks within which residuals may be correlated in any way, (rows,)."""
        return self.problem.blocks

    def residuals(self, x: Array) -> Array:
        """Simulated minus measured over noise, (rows, lanes), for vectors (lanes, n + 1)."""
        zero, stage = x[:, -1], self.problem.stage
        if stage.begins is not None:
            moved: list[Any] = [b.pressure - zero for b in stage.begins]
            begins = (replace(b, pressure=p) for b, p in zip(stage.begins, moved, strict=True))
            stage = replace(stage, begins=tuple(begins))
        return replace(self.problem, stage=stage).residuals(x[:, :-1]) + zero / stage.noise

    def off_jumps(self, x: Array) -> "FromZero":
        """The same with residuals off what times of jumps explain, at a vector (n + 1,)."""
        return FromZero(self.problem.off_jumps(x[:-1]))


@dataclass(frozen=True)
class _Fitted:
    """A fit of the regulator and the zero: vector (n + 1,), bounds (3, n + 1), and the mean square over the
    noise that it leaves."""

    problem: FromZero
    bounds: Array
    vector: Array
    chi2: float


def _fitted(model: Model, offset: float, span: float) -> _Fitted:
    """A model of the regulator fitted with the zero, which is within the pressure's range of `offset`."""
    bounds = np.hstack([model.bounds, [[offset], [offset - span], [offset + span]]])
    problem = FromZero(model.problem)
    x, chi2 = minimise(problem, bounds[0], bounds)
    return _Fitted(problem, bounds, x, chi2)


def counted(campaign: Campaign) -> tuple[Campaign, tuple[Remark, ...]]:
    """The campaign with its pressure counted from what a command of zero asks for, and that it was."""
    logged = tuple(r for r in campaign.fit if r.pressure is not None)
    if not logged:
        return campaign, ()
    start = guessed_set(replace(campaign, fit=logged, stage="regulator"))
    runs = recorded(logged, "pressure")
    seen = first_order(runs)
    played = tuple(Playback(r, start.rig.sample_time) for r in logged)
    noise = noise_of_campaign(logged, "pressure_kPa") or 1.0
    begins = None
    if campaign.start == "unknown":
        begins = tuple(Begin(first_rows(r)[0], 0.0, True) for r in logged)
    stage = Stage("regulator", "pressure_kPa", noise, played, (), start.rig, None, begins)
    late = Model(stage, start, start.values).plus(DeadTime, {"delay": seen.delay})
    model = late.plus(PressureDependentRates, {"ratio": 0.9, "fill": 0.0, "exhaust": 0.0})
    span = float(np.ptp(stage.target))
    found = _fitted(model, seen.offset, span)
    level = level_below(runs, seen)
    if level.gain > 0.0 and np.isfinite(level.least):
        least = {"least": level.gain * level.least}
        bent = model.with_values({"gain": level.gain}).plus(LeastPressure, least)
        flat = _fitted(bent, level.offset, span)
        found = flat if flat.chi2 < FLAT * found.chi2 else found
    bowed = model.plus(SealedLeak, {"rate": 1e-4}).plus(Hyperbola, {"curvature": 0.1})
    curved = _fitted(bowed, seen.offset, span)
    found = curved if curved.chi2 < BENT * found.chi2 else found
    x, problem = found.vector, found.problem
    offset = float(x[-1])
    ends = [end for r in logged for end in (float(r.command.min()), float(r.command.max()))]
    lowest = min(float(x[0]) * end for end in ends) + offset
    below = lowest - min(float(r.pressure.min()) for r in logged if r.pressure is not None)
    corner = corner_of(problem.residuals(x[None, :])[:, 0])
    error = uncertainty(problem, x, found.bounds, corner).std_errors[-1]
    known = error is not None and abs(offset) > CERTAIN * error
    if not known or abs(offset) < WORTH * span or below > BELOW * span:
        return campaign, ()
    names = campaign.names
    campaign = counted_from(campaign, Zero(pressure=offset))
    doubtful = only_sines(logged)
    return campaign, (Remark("counted from", "pressure_kPa", offset, "kPa", names, doubtful=doubtful),)
