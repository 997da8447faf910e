"""What a log alone tells of a rig: rough models, and the parameter set that a fit starts from."""
