"""Which effects are tried: ranked by what they could explain, without those that the command alone may be."""
