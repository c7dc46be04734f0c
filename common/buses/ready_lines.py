"""Which of a site's device lines have something to read: one question to the system for all of them."""

import select
from collections.abc import Sequence
from typing import Protocol


class Line(Protocol):
    """A serial line or a CAN bus."""

    readable: bool | None
    """Whether something waits to be read, as of the last look; None where nobody looks."""

    @property
    def descriptor(self) -> int | None:
        """File descriptor that the system can be asked about; None while the line is not open, or has none."""


class ReadyLines:
    """Looks at all lines of a site. A line that cannot be asked about counts as readable."""

    def __init__(self, lines: Sequence[Line]) -> None:
        """Look at these lines, open or not."""
        self._lines = lines
        self._descriptors: list[int | None] = []
        self._behind: dict[int, list[Line]] = {}
        self._ready: list[Line] = []
        self._poll = select.poll()

    def look(self) -> bool:
        """Set `readable` of each line, and return whether any is; a connection that has ended counts as readable."""
        descriptors = [line.descriptor for line in self._lines]
        if descriptors != self._descriptors:
            self._begin(descriptors)
        for line in self._ready:
            line.readable = False
        self._ready = [line for descriptor, _ in self._poll.poll(0) for line in self._behind[descriptor]]
        for line in self._ready:
            line.readable = True
        return bool(self._ready) or None in descriptors

    def _begin(self, descriptors: list[int | None]) -> None:
        """Lines were opened or lost: from now on look at these descriptors."""
        self._descriptors, self._poll = descriptors, select.poll()
        self._behind, self._ready = {}, []
        for line, descriptor in zip(self._lines, descriptors, strict=True):
            line.readable = descriptor is None
            if descriptor is not None:
                self._behind.setdefault(descriptor, []).append(line)
                self._poll.register(descriptor, select.POLLIN)
