"""What the instrument does, as apart from the rig: rows out of place, channels out of step or of zero."""
