"""Models of one measured channel, fitted, and what they leave."""
