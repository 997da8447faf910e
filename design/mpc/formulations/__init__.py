"""Ways to solve the problem of `design.mpc.problem` every period."""
