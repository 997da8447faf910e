"""The page of two campaigns of one rig: what changed between them."""
