"""What holds for every test: hypothesis draws the same examples in every run, BLAS has one thread, and
tests that share what is costly run in one process."""

import os
from typing import Any

# Before NumPy is loaded, here and in what tests start: its threads wait for each other on small matrices.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest
from hypothesis import settings

settings.register_profile("laws", derandomize=True, deadline=None, database=None, max_examples=60)
settings.load_profile("laws")

TOGETHER = "tests/reports/"
"""A folder whose files share one comparison, `tests.reports.report_samples`."""


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Tests of a file have fixtures in common, which would be made anew in every process."""
    from xdist.scheduler import LoadScopeScheduling

    class ByFile(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return TOGETHER if nodeid.startswith(TOGETHER) else nodeid.partition("::")[0]

    return ByFile(config, log)
