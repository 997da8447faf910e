"""Evaluation: tasks, and the runner that plays controllers on plants and tasks."""
