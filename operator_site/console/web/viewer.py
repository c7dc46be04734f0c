"""Controls the flow of camera pictures to one page, so that no queue forms before a slow page."""

from collections import deque
from dataclasses import dataclass, field

from common.web.access import Visitor
from operator_site.console.camera.camera_picture import Picture

CREDIT = 4
"""Maximum number of pictures sent to a page and not yet drawn; with more, the page waits for a key picture."""


@dataclass(slots=True, eq=False)
class Viewer:
    """Camera pictures of one page. A page that came or that lost a picture waits for a key picture.

    Attributes:
        visitor: user of the page.
        stills: whether the page shows still pictures, because its browser cannot decode the stream.
        waits_for_key: whether the page can decode key pictures only.
        queue: messages that are to be sent.
    """

    visitor: Visitor
    stills: bool = False
    waits_for_key: bool = True
    queue: deque[bytes] = field(default_factory=deque)
    _undrawn: deque[int] = field(default_factory=deque)

    @property
    def has_credit(self) -> bool:
        """Whether a picture may be sent: a page of still pictures has drawn the last one."""
        return len(self._undrawn) < (1 if self.stills else CREDIT)

    @property
    def wants_key(self) -> bool:
        """Whether a key picture would be sent."""
        return self.waits_for_key and self.has_credit

    def offer(self, picture: Picture) -> bool:
        """Queue a picture if the page can decode it and has credit; return whether it was queued."""
        full = not self.has_credit
        if full or (self.waits_for_key and not picture.is_key):
            self.waits_for_key = self.waits_for_key or full
            return False
        self.waits_for_key = False
        self._undrawn.append(picture.sequence)
        self.queue.append(picture.encode())
        return True

    def restart(self, pictures: list[Picture]) -> None:
        """Queue a key picture and all that follow it, as after a jump; they count as one until the last is drawn."""
        self.lost()
        if pictures:
            self.waits_for_key = False
            self._undrawn.append(pictures[-1].sequence)
            self.queue.extend(picture.encode() for picture in pictures)

    def drew(self, sequence: object) -> None:
        """Note that the page has drawn a picture, which acknowledges all earlier ones."""
        if sequence in self._undrawn:
            while self._undrawn.popleft() != sequence:
                pass

    def lost(self) -> None:
        """Note that the page cannot decode what follows."""
        self.waits_for_key = True
        self.queue.clear()
        self._undrawn.clear()
