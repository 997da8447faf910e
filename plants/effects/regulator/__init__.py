"""Effects between the command and the pressure."""
