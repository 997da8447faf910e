"""C99 for the target: a law with its state, without allocation or global state, and how to check it there."""
