"""What goes wrong with what a user hands in, said in one line."""


class InputError(ValueError):
    """Bad input: the message says what is wrong, where, and what to do, in one line."""


class InputWarning(UserWarning):
    """Input that loads but that is probably not what was meant."""
