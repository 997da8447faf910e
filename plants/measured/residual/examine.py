"""Examination of what a fitted model leaves over: sensor noise, or something missing.

Every test has a bound that holds for stationary noise of any colour, with a memory up to about half
a second.  A residual is structured when a test exceeds its bound, set for the whole family of
tests, and what it finds carries more than a smallest share of the noise's variance:
with 30,000 rows the bound alone would be passed by trifles, such as the error of
parameters that are right within their standard errors.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from plants.measured.residual.battery import Battery, make_tests
from plants.measured.residual.curves import BinnedCurve, curves_of
from plants.measured.residual.names import named
from plants.measured.residual.series.joined import join
from plants.measured.residual.series.remainder import Remainder, RemainderStage


@dataclass(frozen=True)
class Finding:
    """One test of a residual.

    test: ``conditional mean``, ``offset``, ``cross-correlation``, ``periodic``, ``events``,
    ``changing size`` or ``whiteness``; variable: what it looks at; statistic, and bound: what noise
    alone stays below in all tests together but for a probability of `battery.FALSE_ALARM`;
    p_value: of this test by itself; share: part of the residual's variance that it accounts for,
    beyond what noise would (for ``changing size``: mean square of the relative change).
    """

    test: str
    variable: str
    statistic: float
    bound: float
    p_value: float
    share: float


@dataclass(frozen=True)
class Examination:
    """What is left of one channel.

    rmse, noise: of the residual, and the floor, in the channel's unit; ratio of the two;
    findings: every test, strongest first; structured: something beyond stationary
    sensor noise is left; depends_on: what on, by order of evidence: names of variables, ``time``
    (wander that no variable explains), ``periodic at 2.31 Hz``, ``events``, ``changing size``,
    ``offset``; curves: figures, by variable or test.
    """

    stage: RemainderStage
    rmse: float
    noise: float
    ratio: float
    findings: tuple[Finding, ...]
    structured: bool
    depends_on: tuple[str, ...]
    curves: Mapping[str, BinnedCurve]


def examine(remainders: Sequence[Remainder], seed: int = 0) -> Examination:
    """Examine the residuals of one stage in all recordings together.

    `seed` is for the noise that blurs coarse rounding (`battery.sizes_over`).  Raises ValueError for none,
    for different stages, or where no recording has 200 rows.
    """
    joined = join(remainders)
    weights = [float(len(r.value)) for r in remainders]
    noise = float(np.sqrt(np.average([r.noise**2 for r in remainders], weights=weights)))
    battery = make_tests(joined, noise, seed, max(r.resolution for r in remainders))
    structured = bool(battery.found())
    rmse = float(np.sqrt(battery.total + joined.mean**2))
    return Examination(
        remainders[0].stage, rmse, noise, rmse / noise if noise > 0.0 else float("inf"),
        tuple(sorted(_findings(battery), key=lambda f: (f.p_value, -f.share))),
        structured, named(battery, seed) if structured else (), curves_of(battery),
    )  # fmt: skip


def _findings(battery: Battery) -> list[Finding]:
    """Every test with its bound for the whole family."""
    total = max(battery.total, 1e-300)
    return [
        Finding(
            kind, variable, e.statistic, e.bound(battery.each), e.p_value,
            e.power if kind == "changing size" else max(0.0, e.power / total),
        )
        for (kind, variable), e in battery.evidence.items()
    ]  # fmt: skip
