"""The page of a design: the recommended gains, what they hold, and what each guarantee costs."""
