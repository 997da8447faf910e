"""What the log of a rig that nobody declared counts from: signs, the pressure's zero, the angle's middle."""
