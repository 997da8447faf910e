"""Monte Carlo counts what it says it counts, by closed forms; its numbers come again to the bit."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from design.controllers.pi import PI
from design.evaluation import steps as loop
from design.evaluation.metrics import Metrics
from design.robustness.box import Box, box_of
from design.robustness.intervals import Given, Interval
from design.robustness.samples.conditions import NONE, Conditions
from design.robustness.samples.draws import CHUNK, draw
from design.robustness.samples.monte_carlo import (
    counted,
    envelopes,
    interval,
    monte_carlo,
    quantiles,
    samples_record,
)
from design.robustness.samples.statements import statements
from design.status import Status  # fmt: skip
from design.synthesis.requirements import Limits
from plants import InputError
from plants.parameters.files import built_in
from plants.wrist import STARTS
from reports.robustness.reasons import because
from reports.robustness.statements import statement_record

FLEXION = built_in("flexion")
TUNED = PI(5.0, 9.0)
SLOPES = Interval("slopes", 0.8, 1.0, 1.2, "1", "the test's", ("a1", "a2", "s"))
FACTORS = Box(FLEXION, (SLOPES,))
P_ONLY, LEFT = PI(1.0, 0.0), 92.5
"""A proportional controller leaves an error that can be written down; the limit on it [% of the step]."""


def left_by_p(factor: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Error [% of a step of 15 deg] that the P controller leaves, in closed form, for a1 = a2 and w1 = w2.

    The command moves the pressure by Kp (r - y) from where it held; y is on the line towards which the
    wrist moves, or still on the transit.
    """
    r, w, Kp = 15.0, 6.0, 1.0
    a, s = 0.36 * factor, 0.0803 * factor
    behind = np.choose(start, [w, 0.0, 2.0 * w, w])  # of the start, below that line's angle [deg]
    on_line = (a * Kp * r - behind) / (1.0 + a * Kp)
    transit = np.where(start == 0, 0.0, s * Kp * r / (1.0 + s * Kp))
    return 100.0 * (1.0 - np.maximum(on_line, transit) / r)


def mirrored(start: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """The start as a step in the minus direction meets it: lines 1 and 2 change places."""
    other = np.choose(start, [0, 2, 1, 3])
    return np.where(reference < 0.0, other, start)


def exact_share() -> float:
    """Probability that a case of `FACTORS` leaves more than `LEFT`: by bisection, memory by memory."""
    shares = []
    for start in range(len(STARTS)):
        low, high = 0.8, 1.2  # the error falls with the factor
        if left_by_p(np.array(high), np.array(start)) > LEFT:
            low = high
        for _ in range(60):
            middle = 0.5 * (low + high)
            above = left_by_p(np.array(middle), np.array(start)) > LEFT
            low, high = (middle, high) if above else (low, middle)
        shares.append((low - 0.8) / 0.4)
    return float(np.mean(shares))


def p_only(samples: int, seed: int):
    limits = Limits(steady_error_percent=LEFT)
    return monte_carlo(FACTORS, P_ONLY, NONE, samples, seed, limits, duration=15.0, jobs=1)


def test_every_case_ends_where_the_closed_form_says():
    found = p_only(600, 1)
    exact = left_by_p(found.drawn["slopes"], mirrored(found.start, found.reference))
    seen = 100.0 * found.metrics.steady_state_error_deg / 15.0
    np.testing.assert_allclose(seen, exact, atol=0.02)
    broken = next(v for v in found.violations if v.requirement == "steady_error_percent")
    assert abs(broken.count - np.count_nonzero(exact > LEFT)) <= 1


def test_the_interval_holds_the_exact_probability_as_often_as_it_claims():
    p, n, seeds = exact_share(), 60, 150
    assert 0.3 < p < 0.7
    held = 0
    for seed in range(seeds):
        v = next(v for v in p_only(n, seed).violations if v.requirement == "steady_error_percent")
        held += v.low <= p <= v.high
    counts = np.arange(n + 1)
    covers = [low <= p <= high for low, high in (interval(int(k), n) for k in counts)]
    coverage = stats.binom.pmf(counts, n, p)[covers].sum()
    assert coverage >= 0.95
    # Of so many seeds, as many as of that probability can be told from chance at 1 in 10 000.
    assert stats.binomtest(held, seeds, coverage).pvalue > 1e-4


@pytest.mark.parametrize(
    ("count", "trials", "low", "high"),
    [(81, 263, 0.2527, 0.3676), (15, 148, 0.0578, 0.1617), (0, 20, 0.0, 0.1684), (1, 29, 0.0009, 0.1776)],
)
def test_the_interval_is_the_published_one(count, trials, low, high):
    """Newcombe, Two-sided confidence intervals for the single proportion, Statistics in Medicine 17
    (1998), table I, Clopper-Pearson."""
    assert interval(count, trials) == pytest.approx((low, high), abs=5e-5)
    assert interval(trials - count, trials) == pytest.approx((1.0 - high, 1.0 - low), abs=5e-5)


@pytest.mark.parametrize(("count", "trials"), [(0, 1), (1, 1), (3, 10), (17, 2000), (2000, 2000)])
def test_the_interval_is_that_of_scipy(count, trials):
    ci = stats.binomtest(count, trials).proportion_ci(0.95, method="exact")
    assert interval(count, trials) == pytest.approx((ci.low, ci.high), rel=1e-9, abs=1e-15)


def test_cases_out_of_reach_are_as_many_as_the_actuator_says_and_counted_apart():
    """Line 1 at 15 deg needs 100 + 21 / 0.36 = 158.3 kPa, which 4 V give where gain >= 39.58 kPa/V; minus
    steps need 41.7 kPa, which any gain gives."""
    box = Box(FLEXION, (Interval("gain", 36.0, 39.0, 44.0, "kPa/V", Given()),))
    found = monte_carlo(box, TUNED, NONE, 3000, 2, duration=1.0)
    limit = (100.0 + 21.0 / 0.36) / 4.0
    exact = (found.drawn["gain"] < limit) & (found.reference > 0.0)
    np.testing.assert_array_equal(found.out_of_reach, exact)
    p = 0.5 * (limit - 36.0) / 8.0
    assert found.beyond.count == exact.sum()
    assert stats.binomtest(int(exact.sum()), 3000, p).pvalue > 1e-4
    assert {v.trials for v in found.violations} == {3000 - found.beyond.count}
    assert found.metrics.iae_deg_s.shape == (3000,)
    assert statements(found)[0].reason.uncounted == found.beyond.count
    assert "out of reach not counted" in because(statements(found)[0])
    reach = statements(found)[-1]
    assert (reach.holds, reach.evidence["violations"]) == (False, found.beyond.count)


def test_where_nothing_is_within_reach_nothing_is_claimed():
    box = Box(FLEXION, (Interval("gain", 10.0, 12.0, 14.0, "kPa/V", Given()),))
    found = monte_carlo(box, TUNED, NONE, 64, duration=0.5)
    assert found.beyond.count > 0
    kept = replace(found, out_of_reach=np.ones(64, bool))
    assert envelopes(kept) is None
    nothing = counted("settles", "not settled", None, "", np.zeros(0, bool))
    assert (nothing.low, nothing.high, nothing.trials) == (0.0, 1.0, 0)
    stated = statements(replace(found, violations=(nothing,)))[0]
    assert (stated.holds, stated.value, stated.evidence["probability"]) == (None, 100.0, None)
    assert np.isnan(quantiles(np.zeros(0))).all()


ALL = Conditions()


def same(a, b, cases: slice = slice(None)) -> None:
    for x, y in zip(vars(a.metrics).values(), vars(b.metrics).values(), strict=True):
        np.testing.assert_array_equal(x[cases], y[cases])
    assert a.drawn.keys() == b.drawn.keys()
    for name in a.drawn:
        np.testing.assert_array_equal(a.drawn[name][cases], b.drawn[name][cases])
    np.testing.assert_array_equal(a.start[cases], b.start[cases])
    np.testing.assert_array_equal(a.reference[cases], b.reference[cases])


@pytest.mark.parametrize("conditions", [NONE, ALL], ids=["none", "all"])
def test_one_seed_gives_the_same_bits_on_one_thread_and_on_two(conditions):
    one, two = (
        monte_carlo(box_of(FLEXION), TUNED, conditions, 2 * CHUNK + 77, 3, duration=1.0, jobs=jobs)
        for jobs in (1, 2)
    )
    same(one, two)
    assert (one.quantiles, one.violations) == (two.quantiles, two.violations)


def test_a_shorter_run_has_the_first_cases_of_a_longer_and_another_seed_has_others():
    long, short, other = (
        monte_carlo(box_of(FLEXION), TUNED, ALL, n, seed, duration=0.5)
        for n, seed in ((CHUNK + 300, 8), (CHUNK + 41, 8), (CHUNK + 41, 9))
    )
    first = replace(long, metrics=long.metrics[: len(short)])
    cut = {n: v[: len(short)] for n, v in long.drawn.items()}
    same(
        replace(first, drawn=cut, start=long.start[: len(short)], reference=long.reference[: len(short)]),
        short,
    )
    assert not np.intersect1d(short.drawn["Tw"], other.drawn["Tw"]).size


@pytest.mark.parametrize(("count", "holds"), [(30, True), (100, None), (150, False)])
def test_a_statement_holds_only_where_the_whole_interval_is_below_its_level(count, holds):
    found = p_only(16, 0)
    broken = counted("settles", "not settled", None, "", np.arange(2000) < count)
    stated = statements(replace(found, violations=(broken,)))[0]
    assert (stated.status, stated.holds) == (Status.SAMPLED, holds)
    assert stated.value == pytest.approx(100 * interval(count, 2000)[1])
    assert statement_record(stated)["violations"] == count


def test_limits_that_are_dropped_are_not_counted():
    found = monte_carlo(FACTORS, TUNED, NONE, 16, limits=Limits(overshoot_percent=None), duration=0.2)
    assert [v.requirement for v in found.violations] == [
        "settles",
        "steady_error_percent",
        "total_variation_V",
    ]


def test_infinite_times_stay_infinite_and_finite_ones_finite():
    values = np.concatenate([np.arange(1.0, 98.0), [np.inf] * 3])
    assert quantiles(values) == (5.0, 50.0, 95.0, np.inf)
    record = samples_record(p_only(16, 0))
    assert record["quantiles"]["settling_time_s"]["0.99"] is None


def test_envelopes_are_the_bands_of_the_first_cases():
    found = monte_carlo(box_of(FLEXION), TUNED, NONE, 128, 4, duration=2.0)
    bands = envelopes(found, 50)
    assert bands is not None
    assert (bands.cases, bands.time[0], bands.time[-1]) == (50, 0.0, pytest.approx(2.0))
    cases = draw(found.task, 0, 50)
    judged, _, t = loop.run(cases.wrist, TUNED, cases.reference, cases.state, duration=2.0, record=True)
    angle = t.angle[::10] * np.sign(cases.reference)
    for band, q in ((bands.low, 5), (bands.middle, 50), (bands.high, 95)):
        np.testing.assert_allclose(band, np.percentile(angle, q, axis=1), atol=1e-12)
    for a, b in zip(vars(judged).values(), vars(found.metrics[:50]).values(), strict=True):
        np.testing.assert_array_equal(a, b)
    assert isinstance(judged, Metrics)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"samples": 0}, "at least 1"),
        ({"seed": -1}, "seed >= 0"),
        ({"reference": 0.0}, "step must be positive"),
        ({"duration": float("inf")}, "duration"),
        ({"conditions": Conditions(load=9.0)}, "more than half of the step"),
    ],
)
def test_numbers_that_make_no_sense_are_refused_in_one_line(given, words):
    with pytest.raises(InputError, match=words) as refused:
        monte_carlo(FACTORS, TUNED, **given)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("given", [{"noise": -0.1}, {"load": float("nan")}, {"dead_time": 1.5}])
def test_conditions_that_make_no_sense_are_refused(given):
    with pytest.raises(InputError, match=next(iter(given))):
        Conditions(**given)
