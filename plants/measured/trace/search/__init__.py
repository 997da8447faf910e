"""The search for effects: where to try them, how they rank, which are kept."""
