"""Loops that switch between branches at any time: quadratic functions, with and without Popov's term."""
