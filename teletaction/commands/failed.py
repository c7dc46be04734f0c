"""How a command says that it has failed."""


class Failed(Exception):
    """Work that was asked for rightly and did not succeed: exit 1."""
