"""Figures and pages for a colleague who never runs anything."""
