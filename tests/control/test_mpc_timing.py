"""The ledger of an MPC's times is what NumPy makes of the records."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from design.mpc.fallback import Info
from design.mpc.timing import ledger

times = st.integers(0, 40_000_000)
infos = st.builds(
    Info, st.sampled_from(["solved", "PI", "held"]), st.just(""), st.integers(0, 9), times, times, times
)


@given(st.lists(infos, min_size=1, max_size=60), st.integers(0, 5), st.floats(1e-3, 0.1))
def test_times_misses_and_rungs_are_those_of_the_steps_that_count(steps, leave_out, period):
    steps = steps + steps[:1] * leave_out
    found, kept = ledger(steps, period, leave_out), steps[leave_out:]
    total = np.array([i.preparation_ns + i.solve_ns + i.wrapper_ns for i in kept]) * 1e-9
    assert (found.steps, found.period) == (len(kept), period)
    assert found.misses == sum(t > period for t in total)
    assert sum(found.rungs.values()) == len(kept)
    assert found.rungs == {r: sum(i.rung == r for i in kept) for r in {i.rung for i in kept}}
    for part, of in (
        (total, found.total),
        ([i.preparation_ns * 1e-9 for i in kept], found.preparation),
        ([i.solve_ns * 1e-9 for i in kept], found.solve),
        ([i.wrapper_ns * 1e-9 for i in kept], found.wrapper),
    ):
        assert (of.median, of.p99, of.most) == pytest.approx(
            (np.median(part), np.quantile(part, 0.99), np.max(part))
        )
    assert found.p99_share * period == pytest.approx(found.total.p99)
