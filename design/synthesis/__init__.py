"""Synthesis of a PI: requirements, search, tuning rules, and what a tuning answers."""
