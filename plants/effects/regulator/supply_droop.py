"""Supply droop: the pressure cannot exceed a supply that sags as air is used and recovers slowly."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from plants.effects.effect import Around, Effect, Number, parameter
from plants.effects.hints import TrialHints
from plants.meanings import remembers


@remembers(sag=("kPa", "how far the supply has sagged"))
class Supply(NamedTuple):
    """How far the supply has sagged [kPa]."""

    sag: Number


class SampledSupply(NamedTuple):
    """Full supply [kPa], sag per kPa that is filled, what is left of a sag after one sample, and how
    the sag saturates [1/kPa]."""

    full: Number
    use: Number
    keep: Number
    per_deepest: Number

    def used(self, s: Supply, before: Number, after: Number) -> Supply:
        """The supply after a sample in which the pressure [kPa] went from `before` to `after`."""
        air = np.maximum(after - before, 0.0)
        return Supply(s.sag * self.keep + self.use * air * (1.0 - s.sag * self.per_deepest))


class SampledCap(SampledSupply):
    """The pressure itself meets the supply."""

    def supply(self, s: Supply, before: Number, after: Number) -> tuple[Supply, Number]:
        after = np.minimum(after, np.maximum(self.full - s.sag, np.minimum(before, after)))
        return self.used(s, before, after), after


class SampledTargetCap(SampledSupply):
    """The regulator aims no higher than the supply, so that the approach slows down before it."""

    def target(self, s: Supply, target: Number, around: Around) -> tuple[Supply, Number]:
        return s, np.minimum(target, self.full - s.sag)

    def supply(self, s: Supply, before: Number, after: Number) -> tuple[Supply, Number]:
        return self.used(s, before, after), after


class SampledFlow(NamedTuple):
    """The supply, the flow that its tube lets through per sample, and 1 / difference of pressure [1/kPa]
    above which that is turbulent."""

    source: SampledSupply
    flow: Number
    per_laminar: Number

    def supply(self, s: Supply, before: Number, after: Number) -> tuple[Supply, Number]:
        drop = np.maximum(self.source.full - s.sag - before, 0.0)
        most = self.flow * drop / np.sqrt(1.0 + drop * self.per_laminar)
        after = np.minimum(after, before + most)
        return self.source.used(s, before, after), after


_SUPPLY = parameter("kPa", "pressure of the rested supply", 10.0, 400.0, 400.0, (180.0, 190.0, 200.0, 210.0))
_USE = parameter("1", "sag of the supply per kPa filled", 0.0, 2.0, 0.0, (0.05, 0.2))
_RECOVERY = parameter("s", "time constant of the supply's recovery", 0.3, 100.0, 8.0, (3.0, 12.0))


@dataclass(frozen=True)
class _Droop(Effect):
    NAME = "supply-droop"
    STAGE = "regulator"
    HAPPENS = "The supply sags"
    BOUND = "taken away"
    SUPPLIES = True

    supply: Number = _SUPPLY
    use: Number = _USE
    recovery: Number = _RECOVERY

    def rest(self, wrist: Any, pressure: Number, angle: Number) -> Supply:
        return Supply(0.0)

    @classmethod
    def trials_on(cls, log: TrialHints) -> Iterator[dict[str, float]]:
        """The trials, and supplies at shares of the pressure that was reached, for rigs of any size."""
        yield from cls.trials(log.rig)
        if log.channel != "pressure_kPa":
            return
        reached, first = float(log.quantiles(0.998)[0]), next(cls.trials(log.rig))["supply"]
        for given in cls.trials(log.rig):
            if given["supply"] == first:
                for share in (1.0, 0.97, 0.9):
                    yield {**given, "supply": share * reached}

    def obstacle(self, pressure: float, angle: float) -> str | None:
        if pressure <= float(self.supply):
            return None
        return f"a supply of {float(self.supply):.4g} kPa, where {pressure:.4g} kPa are needed,"

    def _coefficients(self, dt: float, per_deepest: Number = 0.0) -> tuple[Number, ...]:
        return self.supply, self.use, np.exp(-dt / np.asarray(self.recovery, float)), per_deepest


@dataclass(frozen=True)
class CappedPressure(_Droop):
    """The pressure stops at a supply that sags by `use` [kPa per kPa filled] and recovers [s]."""

    FORM = "the pressure is capped"

    def sampled(self, wrist: Any, dt: float) -> SampledCap:
        return SampledCap(*self._coefficients(dt))


@dataclass(frozen=True)
class _Saturating(_Droop):
    """A sag that comes to rest at `deepest` [kPa]."""

    deepest: Number = parameter("kPa", "deepest sag of the supply", 2.0, 200.0, 200.0, (30.0,))

    def no_bound(self, wrist: Any) -> str | None:
        if self.deepest > self.supply:
            return "the supply may sag below zero and pull the commanded pressure with it"
        return None


@dataclass(frozen=True)
class CappedTarget(_Saturating):
    """As `SaturatingSag`, but the commanded pressure is capped, so that the approach is gradual."""

    FORM = "the commanded pressure is capped"

    def sampled(self, wrist: Any, dt: float) -> SampledTargetCap:
        return SampledTargetCap(*self._coefficients(dt, 1.0 / np.asarray(self.deepest, float)))


@dataclass(frozen=True)
class SaturatingSag(_Saturating):
    """As `CappedPressure`, but a sag comes to rest at `deepest` [kPa]: the compressor keeps up."""

    FORM = "the pressure is capped, the sag saturates"

    def sampled(self, wrist: Any, dt: float) -> SampledCap:
        return SampledCap(*self._coefficients(dt, 1.0 / np.asarray(self.deepest, float)))


@dataclass(frozen=True)
class LimitedFlow(_Droop):
    """Filling is never faster than the supply's tube lets through: `flow` [1/s] times the difference of
    pressure, and from `laminar` [kPa] on, where it is turbulent, with its square root."""

    FORM = "filling is limited by the flow from the supply"

    flow: Number = parameter(
        "1/s", "rate of filling per difference of pressure", 0.2, 500.0, 500.0, (3.0, 12.0)
    )
    laminar: Number = parameter(
        "kPa", "difference of pressure where the flow becomes turbulent", 0.5, 500.0, 30.0
    )

    def sampled(self, wrist: Any, dt: float) -> SampledFlow:
        return SampledFlow(
            SampledSupply(*self._coefficients(dt)), self.flow * dt, 1.0 / np.asarray(self.laminar, float)
        )
