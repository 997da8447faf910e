"""What stands beside the tuned PI: how a robust LQI, a convex-concave PI and a feedforward are designed."""
