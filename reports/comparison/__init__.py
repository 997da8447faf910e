"""The page of a comparison of controllers."""
