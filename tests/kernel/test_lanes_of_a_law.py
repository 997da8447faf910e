"""Lanes of any law: what is not asked for is not recorded, and each goes at least as far as it should."""

import threading
from typing import NamedTuple

import numpy as np
import pytest

from plants.kernel import batches
from plants.kernel.batches import WORTH_A_THREAD, default_jobs, in_turn_or_side_by_side, run_lanes
from plants.kernel.templates import LANES


class Sum(NamedTuple):
    """A total, and how many samples made it."""

    total: float
    count: float


class Share(NamedTuple):
    """What is added of a signal."""

    of: float


def law(s, inputs, c):
    """Adds a share of a signal, and counts."""
    (seen,) = inputs
    return Sum(s.total + c.of * seen, s.count + 1.0)


def both(s, inputs, c):
    """Adds two signals, one of which is each lane's own."""
    one, two = inputs
    return Sum(s.total + c.of * (one + 10.0 * two), s.count + 1.0)


SIGNAL = np.arange(1.0, 41.0)


@pytest.mark.parametrize("jobs", [1, 3, None])
@pytest.mark.parametrize("lanes", [1, 3, 2 * LANES + 1])
def test_sums_are_those_of_plain_python(lanes, jobs):
    shares = np.linspace(1.0, 2.0, lanes)
    last, rows = run_lanes(
        law, Sum(5.0, 0.0), Share(shares), 40, {"seen": SIGNAL}, ("seen",), 4, ("total", "count"), jobs
    )
    np.testing.assert_allclose(last.total, 5.0 + shares * SIGNAL.sum())
    assert rows.shape == (2, 11, lanes)
    sums = np.concatenate([[0.0], np.cumsum(SIGNAL)[3::4]])
    np.testing.assert_allclose(rows[0], 5.0 + sums[:, None] * shares)
    assert rows[1, :, 0].tolist() == list(range(0, 41, 4))


def test_a_last_part_of_a_row_is_not_recorded():
    _, rows = run_lanes(law, Sum(0.0, 0.0), Share(1.0), 10, {"seen": SIGNAL}, ("seen",), 3, ("count",))
    assert rows[0, :, 0].tolist() == [0.0, 3.0, 6.0, 9.0]


@pytest.mark.parametrize("jobs", [1, 2])
def test_nothing_is_recorded_unless_it_is_asked_for(jobs):
    last, rows = run_lanes(law, Sum(0.0, 0.0), Share(np.ones(20)), 10, {"seen": SIGNAL}, ("seen",), jobs=jobs)
    assert rows.shape == (0, 0, 20)
    assert last.count.tolist() == [10.0] * 20


@pytest.mark.parametrize("jobs", [1, 2, 5])
def test_lanes_of_lengths_of_their_own_go_as_far_as_the_longest_beside_them(jobs):
    lanes = 3 * LANES - 2
    each = np.random.default_rng(2).integers(1, 41, lanes)
    last, rows = run_lanes(
        law, Sum(0.0, 0.0), Share(np.ones(lanes)), each, {"seen": SIGNAL}, ("seen",), jobs=jobs
    )
    most = np.array([each[i // LANES * LANES : (i // LANES + 1) * LANES].max() for i in range(lanes)])
    assert last.count.tolist() == most.tolist()
    np.testing.assert_allclose(last.total, np.cumsum(SIGNAL)[most - 1])
    assert rows.shape == (0, 0, lanes)


@pytest.mark.parametrize("jobs", [1, 2])
@pytest.mark.parametrize("lanes", [3, LANES, LANES + 2])
def test_a_signal_of_each_lane_is_held_for_so_many_steps(lanes, jobs):
    own = np.random.default_rng(3).normal(size=(8, lanes))
    last, _ = run_lanes(
        both, Sum(0.0, 0.0), Share(np.ones(lanes)), 40, {"one": SIGNAL}, ("one", "two"), jobs=jobs,
        held={"two": own}, hold=5,
    )  # fmt: skip
    np.testing.assert_allclose(last.total, SIGNAL.sum() + 50.0 * own.sum(axis=0), rtol=1e-12)


def test_what_cannot_be_is_refused():
    share, given = Share(np.ones(3)), {"seen": SIGNAL}
    with pytest.raises(ValueError, match="shorter than the 41 steps"):
        run_lanes(law, Sum(0.0, 0.0), share, 41, given, ("seen",))
    with pytest.raises(ValueError, match="shorter than the 41 steps"):
        run_lanes(
            both,
            Sum(0.0, 0.0),
            share,
            41,
            {"one": np.ones(50)},
            ("one", "two"),
            held={"two": np.ones((8, 3))},
            hold=5,
        )
    with pytest.raises(ValueError, match=r"lanes differ in number: \[3, 4\]"):
        run_lanes(law, Sum(np.zeros(4), 0.0), share, 10, given, ("seen",))
    with pytest.raises(ValueError, match="are not recorded"):
        run_lanes(law, Sum(0.0, 0.0), share, np.array([1, 2, 3]), given, ("seen",), 1, ("total",))
    with pytest.raises(ValueError, match="no signals of their own"):
        run_lanes(
            both,
            Sum(0.0, 0.0),
            share,
            np.array([1, 2, 3]),
            {"one": SIGNAL},
            ("one", "two"),
            held={"two": np.ones((40, 3))},
        )


def test_as_many_threads_as_the_process_may_use_or_as_there_are_processors(monkeypatch):
    monkeypatch.setattr("os.sched_getaffinity", lambda _: {1, 4, 5}, raising=False)
    monkeypatch.setattr("os.cpu_count", lambda: 64)
    assert default_jobs() == 3
    monkeypatch.delattr("os.sched_getaffinity")
    assert default_jobs() == 64
    monkeypatch.setattr("os.cpu_count", lambda: None)
    assert default_jobs() == 1


@pytest.mark.parametrize(
    ("jobs", "count", "steps", "threads"),
    [(2, 2, WORTH_A_THREAD, True), (1, 2, WORTH_A_THREAD, False), (2, 1, WORTH_A_THREAD, False),
     (2, 2, WORTH_A_THREAD - 1, False)],
)  # fmt: skip
def test_work_goes_to_threads_where_there_are_two_and_it_takes_long(monkeypatch, jobs, count, steps, threads):
    monkeypatch.setattr(batches, "default_jobs", lambda: jobs)
    found = in_turn_or_side_by_side(lambda i: (i, threading.current_thread()), range(count), steps)
    assert [i for i, _ in found] == list(range(count))
    assert all((t is not threading.main_thread()) == threads for _, t in found)


def test_rows_of_no_leaf_are_empty():
    _, rows = run_lanes(law, Sum(0.0, 0.0), Share(np.ones(20)), 10, {"seen": SIGNAL}, ("seen",), every=5)
    assert rows.shape == (0, 3, 20)
