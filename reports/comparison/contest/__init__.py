"""The contest: each design on perturbed plants."""
