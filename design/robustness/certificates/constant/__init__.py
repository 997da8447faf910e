"""Constant but unknown parameters on one branch: the mixed structured singular value."""
