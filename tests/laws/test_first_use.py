"""With an empty cache, threads that ask for the same kernel at once all get it."""

from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import numpy as np
import pytest

from plants.kernel import batches, cache
from plants.kernel.batches import run_lanes


def _doubled(state, inputs, c):
    return (2.0 * state[0] + c[0],)


@pytest.mark.slow
def test_threads_may_be_the_first_at_once(tmp_path, monkeypatch):
    monkeypatch.setattr(cache, "cache_folder", lambda: tmp_path)
    for attempt in range(8):
        batches._KERNELS.clear()
        for file in tmp_path.glob("*.kernel"):
            file.unlink()
        together = Barrier(8)

        def work(_: int, together: Barrier = together) -> float:
            together.wait()
            last, _rows = run_lanes(_doubled, (1.0,), (np.full(1, 0.5),), 3, jobs=1)
            return float(last[0][0])

        with ThreadPoolExecutor(8) as pool:
            assert list(pool.map(work, range(8))) == [11.5] * 8, attempt
    assert len(list(tmp_path.glob("*.kernel"))) == 1
    batches._KERNELS.clear()
