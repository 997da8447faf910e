"""The sampled loop with one law of the regulator: slopes that switch at will, and those of the memory."""
