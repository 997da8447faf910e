"""Standard errors hold where residuals are coloured, and say where the data is blind."""

import numpy as np
import pytest

from plants.measured.fitting.estimate import estimate

BOUNDS = np.array([[0.5, 0.5], [-10.0, -10.0], [10.0, 10.0]])


class Line:
    """Residuals of a slope and an offset against data with AR(1) noise of unit spread."""

    def __init__(self, seed: int, correlation: float, rows: int = 4000, offset: float = 0.0) -> None:
        rng = np.random.default_rng(seed)
        shocks = rng.standard_normal(rows) * np.sqrt(1 - correlation**2)
        noise = np.empty(rows)
        noise[0] = rng.standard_normal()
        for n in range(1, rows):
            noise[n] = correlation * noise[n - 1] + shocks[n]
        self.x = np.sin(np.arange(rows) / 300) + offset
        self.y = 2.0 * self.x - 1.0 + noise
        self.blocks = np.arange(rows) // 100

    def off_jumps(self, p):
        return self

    def residuals(self, p):
        return self.x[:, None] * p[:, 0] + p[:, 1] - self.y[:, None]


@pytest.mark.parametrize("correlation", [0.0, 0.9])
def test_intervals_cover_the_truth_as_often_as_they_say(correlation):
    scores = []
    for seed in range(60):
        found = estimate(Line(seed, correlation), BOUNDS, starts=1, seed=0)
        scores += [(found.x[0] - 2.0) / found.std_errors[0], (found.x[1] + 1.0) / found.std_errors[1]]
    # Standard scores: spread 1; with 120 of them the spread is known to 7 %.
    assert np.std(scores) == pytest.approx(1.0, abs=0.25)


def test_errors_correlate_as_in_repeated_experiments():
    found = [estimate(Line(seed, 0.0, offset=1.0), BOUNDS, starts=1, seed=0) for seed in range(60)]
    seen = np.corrcoef(np.array([f.x for f in found]).T)
    told = np.mean([f.correlation for f in found], axis=0)
    assert seen[0, 1] < -0.5
    assert told == pytest.approx(seen, abs=0.15)


def test_an_entry_that_the_data_is_blind_to_has_no_standard_error():
    line = Line(0, 0.0)
    line.x = np.zeros_like(line.x)
    found = estimate(line, BOUNDS, starts=1, seed=0)
    assert found.std_errors[0] is None
    assert found.std_errors[1] > 0.0
    assert found.correlation == pytest.approx(np.diag([0.0, 1.0]))
