"""The page of what a declared wrist lacks of a measured rig."""
