"""Simulation: open loop, closed loop, and what a closed loop is composed of."""
