"""What goes wrong with what a user hands in, said in one line."""


class InputError(ValueError):
    """Bad input: the message says what is wrong, where, and what to do, in one line; draft: a file to start
    from, where one can be guessed."""

    def __init__(self, message: str, draft: str | None = None) -> None:
        super().__init__(message)
        self.draft = draft


class InputWarning(UserWarning):
    """Input that is valid but probably not intended."""
