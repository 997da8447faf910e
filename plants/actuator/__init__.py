"""The actuator: from the command to the pressure, and back."""
