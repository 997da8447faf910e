"""Faults put in on purpose, to see whether tests see them: `python -m tests.mutants`."""
