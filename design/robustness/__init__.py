"""How far gains can be trusted, on every branch of the hysteresis and on every way between them.

Three kinds of statement, never mixed: certificates (proved for a class of loops and checked
outside the solver), predictions (linear theory, describing functions), samples (simulated runs).
"""
