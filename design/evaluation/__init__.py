"""Evaluation: tasks, the runner that plays controllers on plants and tasks, and studies of what they did."""
