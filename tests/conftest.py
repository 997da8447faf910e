"""What holds for every test: hypothesis draws the same examples in every run, BLAS has one thread, and
tests that share what is costly run in one process."""

import os
from pathlib import Path

# Before NumPy is loaded, here and in what tests start: its threads wait for each other on small matrices.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest
from hypothesis import settings

settings.register_profile("laws", derandomize=True, deadline=None, database=None, max_examples=60)
settings.load_profile("laws")

ONE_PROCESS = Path(__file__).parent / "reports"
"""A folder whose files share one comparison, `tests.reports.report_samples`."""


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Tests of a file have fixtures in common and are made one group of ``--dist loadgroup``."""
    for item in items if config.pluginmanager.hasplugin("xdist") else ():
        group = ONE_PROCESS if ONE_PROCESS in item.path.parents else item.path
        item.add_marker(pytest.mark.xdist_group(str(group)))
