"""Fitting a model to recordings: the problem, its solution, and what the data determines."""
