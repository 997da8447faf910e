"""Campaigns: recordings of a rig, read, begun and played back."""
