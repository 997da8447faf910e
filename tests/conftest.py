"""What holds for every test: hypothesis draws the same examples in every run, and BLAS has one thread."""

import os

# Before NumPy is loaded, here and in what tests start: its threads wait for each other on small matrices.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from hypothesis import settings

settings.register_profile("laws", derandomize=True, deadline=None, database=None, max_examples=60)
settings.load_profile("laws")
