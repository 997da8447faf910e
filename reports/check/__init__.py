"""The page of a check: a log of the closed loop beside what its design predicted."""
