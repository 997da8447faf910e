"""Trial values that only the data can suggest: moments, frequencies, the reach of the joint."""

from collections.abc import Iterator
from itertools import product

import numpy as np
from numpy.typing import NDArray

from plants.measured.trace.model import Model
from plants.measured.trace.stage import Form, Stage

Array = NDArray[np.float64]
FREQUENCIES = (0.15, 0.45)
"""Lowest frequency looked for [Hz], and the highest as a share of the rate of the log."""

FROM_REMAINDER = ("periodic-disturbance", "load-step")
"""Effects whose trial values come from the remainder, and are as small as it is."""

MOMENTS = 0.5
"""Spacing [s] of the moments at which a step is looked for."""


def trials(form: Form, model: Model) -> list[dict[str, float]]:
    """Values to try a form at in a model that lacks it."""
    stage, residual = model.stage, -model.linear[0]
    if form.NAME == "periodic-disturbance":
        return [
            {**rest, "frequency": f, "sine": a * stage.noise, "cosine": b * stage.noise}
            for f, a, b in hums(stage, residual)
            for rest in _first(form)
        ]
    if form.NAME == "load-step":
        size = 3.0 * stage.noise
        return [
            {**rest, "moment": moment, "shift": size * sign}
            for moment, sign in steps(stage, model.linear[1], residual)
            for rest in _first(form)
        ]
    if form.NAME == "supply-droop" and stage.name == "regulator":
        return list(form.trials()) + list(_supplies(form, stage))
    if form.NAME == "end-stop":
        return list(_stops(form, stage))
    return list(form.trials())


def _first(form: Form) -> list[dict[str, float]]:
    return [next(form.trials())]


def hums(stage: Stage, residual: Array, count: int = 3) -> list[tuple[float, float, float]]:
    """Frequencies [Hz] with the sine and cosine part that a remainder has most of, phase 0 at time 0.

    The recordings are added with their phases, since a hum runs on through all
    of them.  Half of the frequencies stand highest, half stand out most from
    their neighbours, so that a slow remainder of another kind does not hide a hum.
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
    """Moments [s] at which a shift, and its sign, explains most of a remainder."""
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


def _supplies(form: Form, stage: Stage) -> Iterator[dict[str, float]]:
    """Supplies at shares of the pressure that was reached, on rigs of another size too."""
    reached = float(np.quantile(stage.target, 0.998))
    for given in form.trials():
        if given["supply"] == next(form.trials())["supply"]:
            for share in (1.0, 0.97, 0.9):
                yield {**given, "supply": share * reached}


def _stops(form: Form, stage: Stage) -> Iterator[dict[str, float]]:
    """Stops at shares of the angles that were reached, on either side or both."""
    low, high = np.quantile(stage.target, (0.002, 0.998))
    shares = (1.0, 0.9, 0.75, 0.6)
    kinds = form.kinds()
    lows = [kinds["low"].low, *(s * min(low, -1.0) for s in shares)]
    highs = [kinds["high"].high, *(s * max(high, 1.0) for s in shares)]
    rest = {n: v for n, v in next(form.trials()).items() if n not in ("low", "high")}
    for a, b in list(product(lows, highs))[1:]:
        yield {**rest, "low": float(a), "high": float(b)}
