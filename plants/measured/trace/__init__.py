"""From a residual to its cause: which effect the declared wrist lacks."""
