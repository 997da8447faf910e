"""Intervals of uncertain parameters, and where each comes from: asked for, fitted, or assumed."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from design.status import Status
from plants.errors import InputError
from plants.parameters.quantities import Assumed, Fitted, Parameter


@dataclass(frozen=True)
class Given:
    """An interval that was asked for."""


@dataclass(frozen=True)
class StandardErrors:
    """An interval of so many standard errors either way of a value that was fitted to data."""

    count: float
    data: str


@dataclass(frozen=True)
class AssumedShare:
    """An interval of a share of the value either way; together: parameters that vary by one factor; fitted:
    the value was, without a standard error."""

    share: float
    together: tuple[str, ...] = ()
    fitted: bool = False


Origin = Given | StandardErrors | AssumedShare
"""Where an interval comes from."""


@dataclass(frozen=True)
class Interval:
    """Bounds of a parameter, low < high, in its unit, and where they come from; or, where `scaled` names
    parameters, of the factor by which these differ from the plant's."""

    name: str
    low: float
    nominal: float
    high: float
    unit: str
    origin: Origin
    scaled: tuple[str, ...] = ()

    @property
    def status(self) -> Status | None:
        """Assumed, where nobody measured how far the parameter may lie off and nobody gave it."""
        return Status.ASSUMED if isinstance(self.origin, AssumedShare) else None


def half_width(
    name: str, p: Parameter, shares: Mapping[str, float], sigmas: float, scales: bool
) -> tuple[float, Origin | None]:
    """Half-width of the interval of a parameter and where it comes from; 0 and None where it has none.
    `scales`: with the outer branches, even if stated."""
    share, fitted = shares.get(name, 0.0), isinstance(p.provenance, Fitted)
    if isinstance(p.provenance, Fitted) and p.provenance.std_error is not None:
        return sigmas * p.provenance.std_error, StandardErrors(sigmas, p.provenance.data)
    if fitted or isinstance(p.provenance, Assumed) or scales:
        return share * abs(p.value), AssumedShare(share, fitted=fitted)
    return 0.0, None


def refuse_outside(name: str, low: float, high: float, least: float, most: float, p: Parameter) -> None:
    """Refuse an interval that is empty or inverted, reaches beyond least and most, what its kind of parameter
    allows, or does not hold the value of the plant; all in the parameter's unit.

    Raises InputError, in one line.
    """
    if not (np.isfinite(low) and np.isfinite(high)) or low >= high:
        what = "inverted" if low > high else "empty"
        raise InputError(f"box: {name} = {low:g}:{high:g} {p.unit} is {what}; give low:high with low < high")
    if low < least or high > most:
        raise InputError(f"box: {name} = {low:g}:{high:g} {p.unit} is outside {least:g} to {most:g}")
    if not low <= p.value <= high:
        raise InputError(
            f"box: {name} = {low:g}:{high:g} {p.unit} does not hold the plant's own value {p.value:g}"
        )


def narrowed(interval: Interval, share: float) -> Interval:
    """An interval of standard errors with this share of its width; any other, which somebody stated, as it
    is."""
    if not isinstance(interval.origin, StandardErrors):
        return interval
    middle, fewer = interval.nominal, replace(interval.origin, count=share * interval.origin.count)
    low, high = middle + share * (interval.low - middle), middle + share * (interval.high - middle)
    return replace(interval, low=low, high=high, origin=fewer)
