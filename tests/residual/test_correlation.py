"""The cross-correlation of a residual with changes: its scatter, what it explains, and at which lag."""

import numpy as np
import pytest
from scipy.signal import lfilter

from plants.measured.residual.checks.correlation import correlation
from plants.measured.residual.series.background import (
    first_order,
)
from plants.measured.residual.series.joined import join
from plants.measured.residual.series.remainder import Remainder
from tests.residual.made import DT, coloured


def test_deviation_of_a_cross_correlation_is_what_noise_scatters():
    rng = np.random.default_rng(5)
    rows = 4000
    steps = np.cumsum(rng.standard_normal(rows) * (rng.random(rows) < 0.05))
    series = join([Remainder("r", "wrist", np.arange(rows) * DT, np.zeros(rows), 1.0, {"u": steps})])
    spectrum = first_order(series.frequencies, 0.1, DT)
    z, agreed = [], []
    for _ in range(50):
        value = np.where(series.inside, coloured(len(series.value), 0.1, rng), 0.0)
        found = correlation(series, value, "u", spectrum)
        z.append((found.value / found.deviation)[::30])
        agreed.append(found.agreement[::30])
    assert np.std(z) == pytest.approx(1.0, abs=0.1)
    assert np.std(agreed) == pytest.approx(1.0, abs=0.1)  # changes that are alike scatter as the noise does


@pytest.mark.parametrize("size", [0.5, 3.0])
def test_a_correlation_needs_more_than_a_dozen_changes_as_large_as_each_other(size):
    def of(changes):
        at = (np.arange(4000) % 200 == 100) & (np.arange(4000) < 200 * changes)
        up_and_down = np.where(np.cumsum(at) % 2 == 1, size, 0.0)
        series = join([Remainder("r", "wrist", np.arange(4000) * DT, np.ones(4000), 1.0, {"u": up_and_down})])
        return correlation(series, series.value, "u", np.ones(len(series.frequencies)))

    assert of(1) is of(11) is None
    assert of(13) is not None


@pytest.mark.parametrize("late", [0, 40])
@pytest.mark.parametrize("kept", [0.0, 0.8])
def test_a_correlation_explains_what_follows_the_changes_and_at_which_lag(late, kept):
    """Half of the power, some rows after changes of which each keeps so much of the one before it."""
    rng, rows = np.random.default_rng(6), 20_000
    changes = lfilter([1.0], [1.0, -kept], rng.standard_normal(rows))
    follows = np.roll(changes, late)
    noise = np.std(follows) * rng.standard_normal(rows)
    known = {"u": np.cumsum(changes)}
    series = join([Remainder("r", "wrist", np.arange(rows) * DT, follows + noise, 1.0, known)])
    whole = np.where(series.inside, series.value, 0.0)
    found = correlation(series, whole, "u", np.full(len(series.frequencies), np.var(noise)))
    np.testing.assert_allclose(found.lag, np.arange(-0.5, 3.0 + DT / 2.0, DT), atol=1e-9)
    assert found.lag[np.argmax(np.abs(found.value))] == pytest.approx(late * DT)
    # Products of such changes decay as kept^|lag|.
    assert found.sharpness == pytest.approx((1.0 - kept**2) / (1.0 + kept**2), rel=0.05)
    evidence = found.evidence(2.0)
    assert evidence.statistic == pytest.approx(np.abs(found.value).max() / found.deviation)
    assert evidence.power == pytest.approx(0.5 * 2.0, rel=0.1)
