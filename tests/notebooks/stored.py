"""Where the notebooks are.

`notebooks.build` is imported within tests: what it needs of Jupyter takes seconds to load, for which every
process that collects tests would wait.
"""

from pathlib import Path

HERE = Path(__file__).parents[2] / "notebooks"
TEXTS = sorted(HERE.glob("[0-9]_*.py"))
