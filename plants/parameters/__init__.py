"""Parameters that carry their evidence: specs of what a parameter is, and the built-in sets as TOML."""
