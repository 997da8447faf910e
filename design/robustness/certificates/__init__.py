"""What can be proved of a loop, and the checks outside the solver.

`continuous`: slopes switch at any time, the regulator's law fixed or not; `sampled`: the same of the
loop at 1 ms, at every sample; `constant`: parameters that do not change, on one branch.
"""
