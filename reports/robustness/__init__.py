"""The page of what can be trusted of a pair of gains."""
