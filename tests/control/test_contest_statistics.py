"""Intervals of paired differences cover what they claim, and ranks claim no more than the pairs support."""

import numpy as np
import pytest
from scipy.stats import ttest_rel

from design.contest.statistics import FEWEST, ConfidenceInterval, intervals, ranks


def paired(one, other):
    """The interval of the mean of ``one - other``, (plants,) each."""
    return intervals((one - other)[None])[0]


def test_on_many_normal_differences_the_interval_is_that_of_the_paired_t_test():
    draw = np.random.default_rng(5)
    common = 10.0 * draw.standard_normal(400)
    one, other = common + draw.standard_normal(400) + 0.3, common + draw.standard_normal(400)
    found, exact = paired(one, other), ttest_rel(one, other).confidence_interval(0.95)
    assert found.mean == pytest.approx((one - other).mean())
    assert found.low == pytest.approx(exact.low, abs=0.02)
    assert found.high == pytest.approx(exact.high, abs=0.02)


def test_the_interval_covers_the_mean_of_skewed_differences_about_as_often_as_it_says():
    d = np.random.default_rng(6).exponential(1.0, (400, 60))
    share = np.mean([i.low <= 1.0 <= i.high for i in intervals(d)])
    assert 0.90 <= share <= 0.98


def test_of_a_handful_of_plants_nothing_is_claimed():
    few = np.arange(FEWEST - 1.0)
    assert paired(few + 5.0, few) == ConfidenceInterval(5.0, -np.inf, np.inf)
    assert ranks({"slow": few + 5.0, "quick": few}) == {"slow": (1, 2), "quick": (1, 2)}


def test_the_same_controller_twice_is_a_tie_and_a_better_one_is_ahead_of_both():
    values = np.random.default_rng(7).exponential(1.0, 50)
    found = ranks({"a": values, "b": values.copy(), "best": values - 0.5})
    assert found == {"a": (2, 3), "b": (2, 3), "best": (1, 1)}


@pytest.mark.slow
def test_where_all_are_alike_hardly_any_table_ranks_one_before_another():
    draw = np.random.default_rng(8)
    wrong = 0
    for _ in range(100):
        common = draw.exponential(1.0, 60)
        found = ranks({n: common + draw.standard_normal(60) for n in "abcd"})
        wrong += any(r != (1, 4) for r in found.values())
    assert wrong <= 12  # 5 % are allowed: more than 12 of 100 has a chance of 0.2 %


def test_pairing_tells_apart_what_the_spread_of_the_plants_would_hide():
    draw = np.random.default_rng(9)
    plants = 10.0 * draw.standard_normal(40)
    one, other = plants + 0.1 * draw.standard_normal(40) + 0.2, plants
    assert paired(one, other).sign == 1
    assert paired(other, one).sign == -1
    assert paired(one, other[::-1]).sign == 0
