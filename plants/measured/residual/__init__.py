"""What a fitted model leaves over, and whether that is more than sensor noise."""
