"""Samples: what simulated runs show, drawn at random or searched for the worst."""
