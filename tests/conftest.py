"""What holds for every test: hypothesis draws the same examples in every run of the same files, BLAS has one
thread, tests that share what is costly run in one process, and nothing looks for garbage among modules."""

import gc
import os
import time
from typing import Any

# Before NumPy is loaded, here and in what tests start: its threads wait for each other on small matrices.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest
from hypothesis import settings

settings.register_profile("laws", derandomize=True, deadline=None, database=None, max_examples=60)
settings.load_profile("laws")

TOGETHER = {
    "tests.reports.report_samples": ("tests/reports/", "tests/evaluation/test_study.py"),
    "tests.control.c_target.exported": (
        "tests/control/test_export_files.py", "tests/control/test_export_hostile.py",
        "tests/control/test_export_replay.py", "tests/control/test_export_state.py",
    ),
    "tests.robustness.test_robust_tuning.plain": (
        "tests/robustness/test_robust_lqi.py", "tests/robustness/test_robust_tuning.py",
        "tests/robustness/test_structures.py",
    ),
}  # fmt: skip
"""What files share that is made once a process, and which do."""

APART = (
    "tests/docs/test_additions.py", "tests/measured/test_closed_loop_logs.py",
    "tests/notebooks/test_notebooks_run.py", "tests/trace/test_logs_as_loggers_write_them.py",
    "tests/trace/test_soft_rigs.py",
)  # fmt: skip
"""Files whose tests take minutes and share nothing but by their parameter: each may run by itself."""

LONG = (*APART, "tests/trace/test_gains_of_soft_rigs.py", "tests/trace/test_suite.py")
"""These, and files whose fixture takes minutes."""


BEGUN = time.monotonic()


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--budget", type=float, metavar="SECONDS", help="skip tests that would begin later")


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """On a slow machine the last of the slow tests are left out, so that the others are told in time."""
    budget = item.config.getoption("--budget")
    if budget is not None and time.monotonic() - BEGUN > budget:
        pytest.skip(f"not begun within {budget:.0f} s")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """What takes minutes begins first, so that no process waits for it at the end."""
    items.sort(key=lambda item: not item.nodeid.startswith(LONG))


def pytest_collection_finish() -> None:
    """What is loaded stays: the collector need not look through it, some million objects, again and again."""
    gc.freeze()


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Tests of a file have fixtures in common, which would be made anew in every process."""
    from xdist.scheduler import LoadScopeScheduling

    class ByFile(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            shared = (of for of, files in TOGETHER.items() if nodeid.startswith(files))
            if nodeid.startswith(APART):
                return nodeid.partition("[")[2] or nodeid
            return next(shared, nodeid.partition("::")[0])

    return ByFile(config, log)
