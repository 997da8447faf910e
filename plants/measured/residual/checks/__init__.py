"""Statistical tests of a residual, one a file, each with the law that it follows in noise alone."""
