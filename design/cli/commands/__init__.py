"""The commands of ``wrist``, one a file."""
