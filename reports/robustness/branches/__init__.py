"""Figures of the loop on every branch of the hysteresis."""
