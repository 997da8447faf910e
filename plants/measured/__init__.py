"""What measurements say: recordings, their fit, what is left over, and what causes it."""
