"""The terminal: what is printed on it, and how a run is stopped from it."""
