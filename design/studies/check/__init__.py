"""Back from the rig: a log of the closed loop held against what its design predicted."""
