"""Autocorrelation of a residual, and the test of Ljung and Box.

Reported, never decisive: sensor noise may be coloured.
"""

import numpy as np

from plants.measured.residual.checks.evidence import Evidence
from plants.measured.residual.series.joined import Joined
from plants.measured.residual.series.remainder import Array

LAGS = 20
"""Lags of the test; it holds for white noise, whatever its distribution."""


def autocorrelation(joined: Joined, lags: int) -> Array:
    """Autocorrelation at lags 1 to `lags`, (lags,): of products within recordings only.

    >>> from plants.measured.residual.series.remainder import Remainder
    >>> from plants.measured.residual.series.joined import join
    >>> wave = np.cos(np.pi * np.arange(1000))  # alternates: lag 1 gives -1, but for the last row
    >>> series = join([Remainder("r", "wrist", 0.01 * np.arange(1000.0), wave, 1.0, {})])
    >>> autocorrelation(series, 2).round(3).tolist()
    [-0.999, 0.998]
    """
    from scipy.fft import irfft

    lags = min(lags, len(joined.value) - 1)
    products = irfft(np.abs(joined.transform(joined.value)) ** 2, joined.length)
    # The silences keep recordings apart for lags that they are longer than, and the circle too.
    found: Array = products[1 : lags + 1] / max(products[0], 1e-300)
    return found


def ljung_box(correlation: Array, rows: int) -> Evidence:
    """Test of Ljung and Box (1978) over the lags of an autocorrelation.

    Q = n (n + 2) sum r_k^2 / (n - k), chi-square with as many degrees of freedom as lags under whiteness.

    >>> found = ljung_box(np.array([0.2, -0.1]), 100)  # 100 * 102 * (0.04/99 + 0.01/98)
    >>> round(found.statistic, 3)
    5.162
    """
    k = np.arange(1, len(correlation) + 1)
    statistic = float(rows * (rows + 2.0) * np.sum(correlation**2 / (rows - k)))
    return Evidence(statistic, "chi2", (float(len(correlation)),), 1.0, 0.0)
