"""What pages show of a study beside its verdict: steps of branches and cells, loads, limits, prices."""
