"""What a log tells an effect of where to try it: moments, frequencies, the reach of the joint."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plants.measured.fitting.stage import Form, Stage
from plants.measured.trace.stages.model import Model
from plants.rig import Rig

Array = NDArray[np.float64]
FREQUENCIES = (0.15, 0.45)
"""Lowest frequency looked for [Hz], and the highest as a share of the rate of the log."""

MOMENTS = 0.5
"""Spacing [s] of the moments at which a step is looked for."""


@dataclass(frozen=True)
class StageHints:
    """The log of a stage, and what a model leaves of it; a `plants.effects.effect.TrialHints`."""

    model: Model

    @property
    def channel(self) -> str:
        """What is measured."""
        return self.model.stage.channel

    @property
    def rig(self) -> Rig:
        """The rig whose channel it is."""
        return self.model.stage.rig

    @property
    def noise(self) -> float:
        """Its floor."""
        return self.model.stage.noise

    def quantiles(self, *shares: float) -> Any:
        """Quantiles of what was measured."""
        return np.quantile(self.model.stage.target, shares)

    def spectral_lines(self) -> list[tuple[float, float, float]]:
        """See `spectral_lines`; parts over the noise."""
        return spectral_lines(self.model.stage, -self.model.linear[0])

    def steps(self) -> list[tuple[float, float]]:
        """See `steps`."""
        residual, sensitivity = self.model.linear
        return steps(self.model.stage, sensitivity, -residual)


def trials(form: Form, model: Model) -> list[dict[str, float]]:
    """Values to try a form at in a model that lacks it."""
    return list(form.trials_on(StageHints(model)))


def spectral_lines(stage: Stage, residual: Array, count: int = 3) -> list[tuple[float, float, float]]:
    """Frequencies [Hz] with the sine and cosine part that a residual has most of, phase 0 at time 0.

    The recordings are added with their phases, since a sinusoid runs on through all
    of them.  Half of the frequencies stand highest, half stand out most from
    their neighbours, so that a slow residual of another kind does not hide a hum.
    """
    from scipy.ndimage import median_filter

    dt = float(np.median(np.diff(stage.playbacks[0].recording.time)))
    size = 1 << int(np.ceil(np.log2(4 * max(np.diff(stage.edges)))))
    f = np.fft.rfftfreq(size, dt)
    spectrum = np.zeros(f.size, complex)
    for i, (a, b) in enumerate(zip(stage.edges[:-1], stage.edges[1:], strict=True)):
        first = stage.playbacks[i].recording.time[0]
        spectrum += np.fft.rfft(residual[a:b], size) * np.exp(-2j * np.pi * f * first)
    spectrum *= 2.0 / residual.size
    inside = (f > FREQUENCIES[0]) & (f < FREQUENCIES[1] / dt)
    power = np.where(inside, np.abs(spectrum) ** 2, 0.0)
    around = np.maximum(median_filter(power, 201), 1e-30)
    found: list[int] = []
    for height in (power, power / around):
        left = height.copy()
        for _ in range(count):
            k = int(np.argmax(left))
            found.append(k)
            left[np.abs(f - f[k]) < 0.03] = 0.0
    # r = a sin + b cos has the spectrum (b - i a) / 2 at its frequency; ours is doubled.
    return [(float(f[k]), float(-spectrum[k].imag), float(spectrum[k].real)) for k in dict.fromkeys(found)]


def steps(stage: Stage, sensitivity: Array, residual: Array, count: int = 3) -> list[tuple[float, float]]:
    """Moments [s] at which a shift, and its sign, explains most of a residual."""
    last = max(float(p.recording.time[-1]) for p in stage.playbacks)
    moments = np.arange(MOMENTS, last - MOMENTS, MOMENTS)
    thin = slice(None, None, 5)
    q, _ = np.linalg.qr(sensitivity[thin])
    shifted = (stage.time[thin, None] >= moments).astype(float)
    shifted -= q @ (q.T @ shifted)
    along = residual[thin] @ shifted
    gain = along**2 / np.maximum(np.sum(shifted**2, axis=0), 1.0)
    found = []
    for _ in range(count):
        k = int(np.argmax(gain))
        found.append((float(moments[k]), float(np.sign(along[k]))))
        gain[np.abs(moments - moments[k]) < 2.0] = 0.0
    return found
