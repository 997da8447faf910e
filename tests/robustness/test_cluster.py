"""A Dask cluster gives the bits that one process gives, also when a worker is killed half-way."""

import os
import signal
import sys
import time
import warnings
from collections import Counter
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from design.cluster import each
from design.controllers.pi import PI
from design.evaluation.cases import Case
from design.evaluation.tasks import Task
from design.robustness.box import box_of
from design.robustness.samples.conditions import Conditions
from design.robustness.samples.draws import CHUNK
from design.robustness.samples.monte_carlo import Samples, monte_carlo
from design.synthesis.requirements import Limits, Problem
from design.synthesis.tuning import Region, tune
from plants import InputError, Wrist
from plants.parameters.files import built_in

# What distributed leaves to the garbage collector when a worker was killed is not ours to close.
pytestmark = pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")

SAMPLES, SECONDS = 12 * CHUNK + 100, 1.0


@pytest.fixture(scope="module")
def cluster():
    """Two worker processes of one thread each, and a nanny that replaces one that dies."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # those of distributed itself, about this machine
        import logging

        from distributed import LocalCluster

        made = LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address="127.0.0.1:0",
            silence_logs=logging.CRITICAL, host="127.0.0.1",
        )  # fmt: skip
        try:
            yield made
        finally:
            made.close()


@pytest.fixture
def address(cluster):
    return cluster.scheduler_address


def workers(address: str) -> dict[str, int]:
    """Process ids of the workers that the fixture started, by their addresses."""
    from distributed import Client

    with Client(address, set_as_default=False) as client:
        client.wait_for_workers(2, timeout=300)
        return client.run(os.getpid)


def sampled(scheduler: str | None = None, progress=None) -> Samples:
    return monte_carlo(
        box_of(built_in("flexion")), PI(5.0, 9.0), Conditions(), SAMPLES, 7,
        duration=SECONDS, jobs=1, scheduler=scheduler, progress=progress,
    )  # fmt: skip


@cache
def here() -> Samples:
    return sampled()


def require_same(a: Samples, b: Samples) -> None:
    assert len(a) == len(b) == SAMPLES
    for x, y in zip(vars(a.metrics).values(), vars(b.metrics).values(), strict=True):
        np.testing.assert_array_equal(x, y)
    for name in a.drawn:
        np.testing.assert_array_equal(a.drawn[name], b.drawn[name])
    assert (a.quantiles, a.violations, a.beyond) == (b.quantiles, b.violations, b.beyond)


@pytest.mark.slow
def test_monte_carlo_on_two_workers_is_monte_carlo_here(address):
    told = []
    require_same(sampled(address, lambda stage, share: told.append((stage, share))), here())
    assert [share for _, share in told] == sorted(share for _, share in told)
    assert told[-1] == ("samples", 1.0)


@pytest.mark.suite
def test_the_map_of_a_tuning_on_two_workers_is_the_map_here(address):
    wrist = Wrist.flexion()
    problem = Problem.of(wrist, [Case(Task("virgin", 0.0, (15.0,)), wrist)], Limits(), duration=1.0)
    region = Region(points=29)  # 841 gains, four pieces
    there, local = (tune(problem, region, starts=1, scheduler=a) for a in (address, None))
    for name in ("Kp", "Ki", "cost", "cost_at", "worst_excess"):
        np.testing.assert_array_equal(getattr(there.map, name), getattr(local.map, name))
    assert (there.Kp, there.Ki, there.searches) == (local.Kp, local.Ki, local.searches)


def test_which_worker_does_which_piece_is_chance_and_the_order_of_results_is_not(address):
    def slow(number: int) -> tuple[int, int]:
        time.sleep(0.05 if number % 3 == 0 else 0.001)
        return number, os.getpid()

    done = each(slow, range(24), address)
    assert [number for number, _ in done] == list(range(24))
    assert {pid for _, pid in done} == set(workers(address).values())


@pytest.mark.suite
def test_a_worker_killed_half_way_loses_nothing_and_counts_nothing_twice(address, tmp_path):
    victim, ran = min(workers(address).values()), str(tmp_path)

    def leave_a_mark(number: int) -> tuple[int, int]:
        Path(ran, f"{number}-{os.getpid()}-{time.monotonic_ns()}").touch()
        time.sleep(0.1)
        return number, number * number

    def kill_once(share: float) -> None:
        if share >= 0.25 and not killed:
            killed.append(share)
            while not any(busy(mark) for mark in tmp_path.iterdir()):  # until it is in the midst of a piece
                time.sleep(0.002)
            os.kill(victim, signal.SIGKILL)

    def busy(mark: Path) -> bool:
        _, pid, begun = map(int, mark.name.split("-"))
        return pid == victim and time.monotonic_ns() - begun < 50_000_000  # it takes 100 ms

    killed: list[float] = []
    done = each(leave_a_mark, range(24), address, kill_once)
    assert killed
    assert killed[0] < 1.0
    assert done == [(n, n * n) for n in range(24)]
    begun = Counter(int(mark.name.split("-")[0]) for mark in tmp_path.iterdir())
    assert set(begun) == set(range(24))
    assert max(begun.values()) > 1  # a piece was lost, and done again
    assert victim not in workers(address).values()


@pytest.mark.suite
def test_monte_carlo_with_a_worker_killed_half_way_is_monte_carlo_here(address):
    victim = max(workers(address).values())
    killed = []

    def kill_once(_stage: str, share: float) -> None:
        if not killed:
            killed.append(share)
            os.kill(victim, signal.SIGKILL)

    require_same(sampled(address, kill_once), here())
    assert killed[0] < 0.5
    assert victim not in workers(address).values()


def test_what_a_piece_raises_is_raised_here(address):
    def refuse(number: int) -> int:
        if number == 3:
            raise InputError("three is wrong")
        return number

    for scheduler, jobs in ((address, 1), (None, 1), (None, 2)):
        with pytest.raises(InputError, match="three is wrong"):
            each(refuse, range(6), scheduler, jobs=jobs)


@pytest.mark.parametrize("wrong", ["tcp://127.0.0.1:9", "127.0.0.1:9", "nonsense"])
def test_a_scheduler_that_cannot_be_reached_is_named_in_one_line(wrong, monkeypatch):
    monkeypatch.setattr("design.cluster.REACHED_WITHIN", 0.5)
    with pytest.raises(InputError) as refused:
        each(abs, [1], wrong)
    words = str(refused.value)
    assert "\n" not in words
    assert words.startswith(f"scheduler {wrong}: cannot be reached")
    assert "dask scheduler" in words


def test_a_scheduler_without_workers_is_refused(monkeypatch):
    import logging

    from distributed import LocalCluster

    monkeypatch.setattr("design.cluster.REACHED_WITHIN", 0.5)
    with (
        LocalCluster(
            n_workers=0, dashboard_address="127.0.0.1:0", silence_logs=logging.CRITICAL, host="127.0.0.1"
        ) as c,
        pytest.raises(InputError, match="has no workers"),
    ):
        each(abs, [1], c.scheduler_address)


def test_without_the_package_the_refusal_says_how_to_install_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match=r'pip install "wrist-workbench\[cluster\]"'):
        each(abs, [1], "tcp://127.0.0.1:8786")
