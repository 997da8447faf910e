"""The structure that a trace found, on another campaign of the same rig."""
