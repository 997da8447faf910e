"""The loop as it is sampled: switched systems, forms of higher degree, and words that speak against them."""
