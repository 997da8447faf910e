"""Statistical tests of a remainder, one a file, each with the law that it follows in noise alone."""
