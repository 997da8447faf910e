"""Model predictive control of the wrist: one problem, several ways to solve it every period."""
