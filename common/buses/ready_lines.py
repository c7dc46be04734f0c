"""Polls all device lines of a site for readable data with one system call."""

import select
from collections.abc import Sequence
from typing import Protocol


class Line(Protocol):
    """A serial line or a CAN bus."""

    readable: bool | None
    """Whether data wait to be read, as of the last poll; None where nothing polls the line."""

    @property
    def descriptor(self) -> int | None:
        """File descriptor to poll; None while the line is closed or has none."""


class ReadyLines:
    """Polls all lines of a site. A line without a descriptor counts as readable."""

    def __init__(self, lines: Sequence[Line]) -> None:
        self._lines = lines
        self._descriptors: list[int | None] = []
        self._behind: dict[int, list[Line]] = {}
        self._ready: list[Line] = []
        self._poll = select.poll()

    def look(self) -> bool:
        """Set `readable` of each line and return whether any is readable; an ended connection counts as readable."""
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
        """Use new descriptors after lines were opened or lost."""
        self._descriptors, self._poll = descriptors, select.poll()
        self._behind, self._ready = {}, []
        for line, descriptor in zip(self._lines, descriptors, strict=True):
            line.readable = descriptor is None
            if descriptor is not None:
                self._behind.setdefault(descriptor, []).append(line)
                self._poll.register(descriptor, select.POLLIN)
