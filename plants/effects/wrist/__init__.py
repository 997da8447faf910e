"""Effects between the pressure and the angle."""
