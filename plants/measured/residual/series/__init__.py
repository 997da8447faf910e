"""A residual as a series, its spectrum, and the columns that it is regressed on."""
