"""Defines the exception with which a command reports a failure."""


class Failed(Exception):
    """The arguments were valid, but the command did not succeed: exit code 1."""
