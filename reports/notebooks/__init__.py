"""Tables and figures that only notebooks show."""
