"""The MPCs as C: what both have in common, the linear one, the one by real-time iteration."""
