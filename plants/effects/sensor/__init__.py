"""Effects on what the sensor of the angle shows."""
