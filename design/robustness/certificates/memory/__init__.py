"""The sampled loop with the regulator's law fixed: slopes that switch at will, and slopes that the loop's memory
chooses."""
