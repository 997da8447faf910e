"""Names of what a residual depends on: the strongest first, no more than are needed, and none by mistake."""

import numpy as np
import pytest

from plants.measured.residual.checks.events import BASELINE, _baseline
from plants.measured.residual.examine import examine
from plants.measured.residual.names import MOST
from plants.measured.residual.series.joined import join
from plants.measured.residual.series.remainder import Remainder
from tests.residual.made import DT

ROWS = 20_000


def remainders(variables, value, seed=0, rows=ROWS):
    """One recording of white noise of 1, and a value beside it that is made of variables by name."""
    noise = np.random.default_rng([seed, 7]).standard_normal(rows)
    return [Remainder("r", "wrist", np.arange(rows) * DT, noise + value(variables), 1.0, variables)]


def levels(name, rows=ROWS):
    """Levels between -1 and 1, each held for a fifth of a second, another series for each name."""
    draw = np.random.default_rng([ord(c) for c in name])
    return np.repeat(draw.uniform(-1.0, 1.0, rows // 20 + 1), 20)[:rows]


def bowl(x):
    """Even, so that it does not follow the changes of a variable, with a mean of 0."""
    return 3.0 * (x**2 - 1.0 / 3.0)


STRENGTHS = {"v": 1.2, "w": 1.0, "x": 0.85, "y": 0.6, "z": 0.5}


@pytest.mark.parametrize("names", ["v", "vw", "vwx", "vwxy", "vwxyz"])
def test_variables_are_named_in_order_of_what_they_account_for_and_three_at_most(names):
    variables = {n: levels(n) for n in "vwxyz"}
    found = examine(remainders(variables, lambda of: sum(STRENGTHS[n] * bowl(of[n]) for n in names)))
    assert found.structured
    assert "".join(n for n in found.depends_on if n in variables) == names[:MOST]


@pytest.mark.parametrize("names", ["v", "vw"])
def test_all_there_are_may_be_named(names):
    variables = {n: levels(n) for n in names}
    found = examine(remainders(variables, lambda of: sum(STRENGTHS[n] * bowl(of[n]) for n in names)))
    assert found.depends_on == tuple(names)


@pytest.mark.parametrize(("share", "named"), [(0.06, False), (0.2, True)])
def test_what_does_a_tenth_of_what_the_first_does_is_worth_a_name(share, named):
    variables = {"v": levels("v"), "w": levels("w")}
    found = examine(remainders(variables, lambda of: 2.0 * (bowl(of["v"]) + share**0.5 * bowl(of["w"]))))
    assert found.depends_on == (("v", "w") if named else ("v",))


@pytest.mark.parametrize("last", [80.0, 200.0])
def test_a_hum_is_named_where_it_lasts(last):
    time = np.arange(ROWS) * DT
    hum = np.where(time < last, np.sin(2.0 * np.pi * 3.0 * time), 0.0)
    found = examine(remainders({"v": levels("v")}, lambda of: bowl(of["v"]) + hum))
    assert found.depends_on == (("v", "periodic at 3 Hz") if last == 200.0 else ("v",))


def test_noise_alone_has_no_line_to_name():
    found = examine(remainders({"v": levels("v")}, lambda of: bowl(of["v"])))
    assert found.depends_on == ("v",)


def test_loud_noise_is_a_size_and_no_event():
    """White noise that is four times as loud now and then: nothing stands out for its surroundings."""
    loud = np.where(levels("l") > 0.8, 4.0, 1.0)
    more = np.random.default_rng(5).standard_normal(ROWS) * np.sqrt(loud**2 - 1.0)
    found = examine(remainders({"v": levels("v")}, lambda _: more))
    assert found.depends_on[-1] == "changing size"
    assert "events" not in found.depends_on


def test_bumps_are_events_where_they_are_rare():
    def bumps(every):
        return 5.0 * np.isin(np.arange(ROWS) % round(every / DT), np.arange(30)) * (np.arange(ROWS) > 500)

    draw = np.random.default_rng(3)
    at = np.sort(draw.choice(ROWS // 400, 12, replace=False)) * 400 + draw.integers(50, 300, 12)
    rare = np.zeros(ROWS)
    for k in at:
        rare[k : k + 30] = 5.0
    assert "events" in examine(remainders({"v": levels("v")}, lambda _: rare)).depends_on
    assert "events" not in examine(remainders({"v": levels("v")}, lambda _: bumps(0.7))).depends_on


@pytest.mark.parametrize("dt", [0.1, 0.2])
def test_of_a_slow_log_the_baseline_is_the_running_median_of_its_rows(dt):
    """Where a row lasts a tenth of a second or more there is nothing to average."""
    from scipy.ndimage import median_filter

    rows = 300
    value = np.cumsum(np.random.default_rng(8).standard_normal(rows))
    series = join([Remainder("r", "wrist", np.arange(rows) * dt, value, 1.0, {})])
    expected = median_filter(series.value[series.spans[0]], round(BASELINE / 0.1) | 1, mode="nearest")
    found = _baseline(series, series.value)[series.spans[0]]
    assert np.abs(found - expected).max() <= np.abs(np.diff(expected)).max()  # to a row


@pytest.mark.parametrize("dt", [0.01, 0.02, 0.1])
def test_a_baseline_follows_what_is_slow_and_passes_over_what_is_short(dt):
    time = np.arange(0.0, 60.0, dt)
    slow, short = 0.2 * time, np.where((time > 30.0) & (time < 31.0), 50.0, 0.0)
    series = join([Remainder("r", "wrist", time, slow + short, 1.0, {})])
    inside = (time > 3.0) & (time < 57.0)
    level = _baseline(series, series.value)[series.spans[0]] - (slow - (slow + short).mean())
    assert np.abs(level[inside]).max() < 0.2 * 1.1  # an excursion moves the median by half its length
    calm = inside & (np.abs(time - 30.5) > 3.0)
    assert np.abs(level[calm]).max() < 0.2 * dt + 1e-9
