"""The battery of tests on the residuals of a stage, and what passes as found."""

from dataclasses import dataclass

import numpy as np

from plants.measured.residual.checks.conditional import Sums, sums_of
from plants.measured.residual.checks.correlation import Correlation, correlation
from plants.measured.residual.checks.events import Events, events_in
from plants.measured.residual.checks.evidence import Evidence
from plants.measured.residual.checks.periodic import Line, Spectrum, harmonic, line_in, spectrum_of
from plants.measured.residual.checks.size import burst_test, size_tests, sizes_of
from plants.measured.residual.checks.whiteness import LAGS, autocorrelation, ljung_box
from plants.measured.residual.series.background import background
from plants.measured.residual.series.bins import Bins, bins_of, stretches
from plants.measured.residual.series.design import Design, design_of
from plants.measured.residual.series.joined import Joined
from plants.measured.residual.series.remainder import Array

FALSE_ALARM = 2e-5
"""Probability that noise alone exceeds any of the bounds of one examination."""

SMALLEST = {
    "conditional mean": 0.02,
    "cross-correlation": 0.02,
    "periodic": 0.02,
    "offset": 0.02,
    "events": 0.01,
    "changing size": 0.01,
}
"""Smallest part that counts as structure: of the noise's variance, or the residual's where that is larger.

0.02 is an effect whose spread is a seventh of the noise.  Events are rare, and large while they
last.  For a changing size it is the mean square of the relative change: a tenth up and down.
"""

FINE = 0.67
"""Steps finer than the noise floor divided by this are blurred by the noise; coarser ones are rounding."""

BLURRED = 0.35
"""Below this part of a step the noise floor is rounding and little else."""

KNOWN = 0.36
"""Degrees of freedom with which the noise's spectrum is known where it is slow, per second measured.

From the scatter of `background` at frequency zero over simulated noise, 14 % for 280 s.
"""

MADE = (
    "pressure_kPa",
    "pressure_rate_kPa_s",
    "direction",
    "angle_deg",
    "time_s",
    "since_reversal_s",
    "work_kPa",
)
"""Variables made from the simulation or the time; all others are logged, and may be inputs."""

Key = tuple[str, str]


@dataclass(frozen=True)
class Battery:
    """All tests made on a series, and what they were made of.

    noise: floor, of which rounding is a part; rounding: size of the steps that the channel comes in,
    0 where noise blurs them; design: indicators of all bins, and waves of the line; evidence:
    by kind of test and variable.
    """

    joined: Joined
    noise: float
    rounding: float
    noise_spectrum: Array
    bins: tuple[Bins, ...]
    design: Design
    sums: Sums
    spectrum: Spectrum
    line: Line | None
    correlations: tuple[Correlation, ...]
    autocorrelation: Array
    evidence: dict[Key, Evidence]

    @property
    def total(self) -> float:
        """Variance of the residual."""
        return float(np.mean(self.joined.value[self.joined.inside] ** 2))

    @property
    def rounding_power(self) -> float:
        """Mean square that rounding may leave of the signal itself, where noise does not blur the steps."""
        return self.rounding**2 / 12.0 if self.noise < BLURRED * self.rounding else 0.0

    @property
    def freedom(self) -> float:
        """Degrees of freedom of the noise's spectrum."""
        return freedom_of(self.joined.duration)

    @property
    def each(self) -> float:
        """Probability of a false alarm that each test is allowed."""
        return FALSE_ALARM / len(self.evidence)

    def counts(self, kind: str, evidence: Evidence) -> bool:
        """Whether a test has found something: beyond its bound, and large enough to matter."""
        if kind == "whiteness":
            return False
        if kind == "changing size":
            least = SMALLEST[kind]
        else:
            least = SMALLEST[kind] * max(self.noise**2, self.total) + self.rounding_power
        return evidence.p_value < self.each and evidence.power > least

    def found(self) -> list[Key]:
        """All tests that have found something."""
        return [key for key, e in self.evidence.items() if self.counts(key[0], e)]


def freedom_of(duration: float) -> float:
    """Degrees of freedom of a noise spectrum that was found in so long a time [s], where it is slow."""
    return max(10.0, KNOWN * duration)


def make_tests(joined: Joined, noise: float, seed: int, resolution: float = 0.0) -> Battery:
    """Make all tests on a series, whose noise floor and smallest step are known [its unit]."""
    rounding = resolution if resolution * FINE > noise else 0.0
    total = float(np.mean(joined.value[joined.inside] ** 2))
    noise_spectrum = np.maximum(background(joined), max(1e-6 * noise**2, 1e-9 * total, 1e-30))
    bins = (*(b for n in joined.variables if (b := bins_of(joined, n))), stretches(joined))
    design = design_of(joined, bins)
    spectrum = spectrum_of(joined, noise_spectrum)
    line = line_in(joined, spectrum)
    if line is not None:
        design = design.with_waves(line.name, harmonic(joined, line.frequency))
    sums = sums_of(joined, joined.value, design, noise_spectrum)
    crossed = correlated(joined, joined.value, noise_spectrum)
    acf = autocorrelation(joined, LAGS)
    battery = Battery(
        joined, noise, rounding, noise_spectrum, bins, design, sums, spectrum, line, crossed, acf, {}
    )  # fmt: skip
    for b in bins:
        battery.evidence["conditional mean", b.variable] = sums.test(
            design.where[b.variable], battery.freedom
        )
    if line is not None:
        battery.evidence["periodic", line.name] = line.evidence
    for c in crossed:
        battery.evidence["cross-correlation", c.variable] = c.evidence(battery.total)
    battery.evidence["offset", "offset"] = _offset(battery)
    battery.evidence["events", "events"] = events_in(joined, joined.value, noise_spectrum).evidence
    for variable, e in sizes_over(battery, joined.value, seed).items():
        battery.evidence["changing size", variable] = e
    battery.evidence["whiteness", "lags"] = ljung_box(acf, joined.rows)
    return battery


def correlated(joined: Joined, series: Array, noise_spectrum: Array) -> tuple[Correlation, ...]:
    """Correlation of a series with the changes of each logged channel that is an input."""
    names = [n for n in joined.variables if n not in MADE]
    return tuple(c for n in names if (c := correlation(joined, series, n, noise_spectrum)) is not None)


def sizes_over(battery: Battery, series: Array, seed: int) -> dict[str, Evidence]:
    """Tests of the size of a series: over each variable, and in bursts.

    Coarse rounding makes a signal that rests look quiet: noise as large as a step is added, so that
    only a change of size beyond it counts.
    """
    joined, spectrum = battery.joined, battery.noise_spectrum
    if battery.rounding > 0.0:
        # A stream of its own: noise made elsewhere from the same seed must not come again.
        blur = np.random.default_rng([seed, 1]).normal(0.0, battery.rounding, len(series))
        series, spectrum = series + np.where(joined.inside, blur, 0.0), spectrum + battery.rounding**2
    sizes = sizes_of(joined, series, spectrum)
    names = [b.variable for b in battery.bins]
    return size_tests(joined, sizes, battery.design, names) | {"bursts": burst_test(joined, sizes)}


def events_of(battery: Battery, series: Array) -> Events:
    """Events in a series."""
    return events_in(battery.joined, series, battery.noise_spectrum)


def _offset(battery: Battery) -> Evidence:
    """Whether the mean of the whole residual differs from zero."""
    joined = battery.joined
    variance = float(battery.noise_spectrum[0]) / joined.rows
    return Evidence(joined.mean**2 / variance, "f", (1.0, battery.freedom), 1.0, joined.mean**2 - variance)
