"""What can be proved of a loop, rung by rung: each rung proves more, and takes more for granted."""
