"""What linear theory and the describing function predict of a loop: predictions, not certificates.

Margins hold on one branch at one rate for ever; the describing function knows one harmonic of the
oscillation.  Neither proves anything of a loop that moves between branches, so that each predicted
limit cycle, and the absence of any, is put to the simulator.
"""
