"""Commands that read logs of a rig."""
