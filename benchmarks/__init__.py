"""How fast the workbench is, beside other ways to do the same: ``python -m benchmarks``.

Nothing here passes or fails by a time; it fails where the contestants do not compute the same.
"""
