"""What a running study shares with who runs it: its progress, and that it cannot run here."""

from collections.abc import Callable

Progress = Callable[[float | str], object]
"""Takes the progress of a study: the share done, 0..1, or what is being done, in words."""


class Unavailable(ValueError):
    """Something that a study measures with is not here; the message says what, and how to name it."""
