"""Collects messages as arrays. A message takes a tenth of the memory that it takes as an object."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Values = Callable[[list[Any]], dict[str, Floats]]
"""Returns the values of n messages by name, each (n,) or (n, 5); for no message the names of all messages."""
_AT_ONCE = 4096
"""Number of messages that are kept as objects."""


def as_floats(values: list[Any]) -> Floats:
    """Return numbers as an array; None becomes NaN."""
    return np.array(values, dtype=np.float64)


class Columns:
    """The values of one stream's messages."""

    def __init__(self, values: Values):
        """Begin without a message."""
        self._values = values
        self._messages: list[Any] = []
        self._parts: list[dict[str, Floats]] = []

    def append(self, message: Any) -> None:
        """Add a message."""
        self._messages.append(message)
        if len(self._messages) >= _AT_ONCE:
            self._convert()

    def arrays(self) -> dict[str, Floats]:
        """Return the values of all messages by name; the messages are then forgotten."""
        if self._messages or not self._parts:
            self._convert()
        parts, self._parts = self._parts, []
        return {name: np.concatenate([part.pop(name) for part in parts]) for name in list(parts[0])}

    def _convert(self) -> None:
        self._parts.append(self._values(self._messages))
        self._messages = []
