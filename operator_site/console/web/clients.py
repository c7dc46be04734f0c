"""Controls the flow of messages to one page, so that no queue forms before a slow or sleeping page.

A page may have CREDIT pictures that it has not drawn yet. It returns credit when it has drawn a picture, because a
sleeping page receives messages without a limit and draws none.
"""

from collections import deque
from dataclasses import dataclass, field
from typing import Any

from common.web.access import Visitor
from operator_site.console.map.map_tiles import MapTile

CREDIT = 2
"""Maximum number of pictures sent to a page and not yet drawn."""
AWAKE_S = 3.0
"""Longest silence of a page that is awake, s. A sleeping page receives nothing, and everything again on waking."""
SEEN_S = 2.5
"""Longest time without a drawn picture after which a page still counts as seen, s: two heartbeats."""
STATE_EVERY_S = 0.25
"""Interval between two states, s."""
URGENT_S = 0.1
"""Shortest interval between two states after an urgent change, s."""
TILES_EVERY_S = 0.1
"""Interval between two groups of tiles, s."""
TILES_AT_ONCE = 4
"""Maximum number of tiles in a group."""
MOST_ANSWERS = 100
"""Maximum number of waiting answers; a page that exceeds it is disconnected."""


@dataclass(slots=True)
class Client:
    """State of the messages to one page. Pure: time is an argument, s.

    Attributes:
        visitor: user of the page.
        name: name of this page, unique among all pages.
        heard_s: time of its newest message.
        quantities: quantities of the map that it shows, one or two; the first is the main one.
        visible: whether the page reports that it is visible.
        skipped: number of pictures that were not sent for lack of credit.
    """

    visitor: Visitor
    name: str
    heard_s: float
    quantities: tuple[str, ...] = ("temperature",)
    visible: bool = True
    skipped: int = 0
    answers: deque[dict[str, Any]] = field(default_factory=deque)
    last_bin: int | None = None
    tiles: deque[MapTile] = field(default_factory=deque)
    """Tiles that are still to be sent."""
    tile_revision: int = 0
    """Revision of the map that the page has once it has all tiles."""
    map_number: int = 0
    _undrawn: deque[int] = field(default_factory=deque)
    _drawn_s: float = 0.0
    _sequence: int = 0
    _state_s: float = 0.0
    _urgent: object = None
    _tiles_s: float = 0.0

    def __post_init__(self) -> None:
        self._drawn_s = self.heard_s

    @property
    def acts(self) -> bool:
        """Whether the visitor may act."""
        return self.visitor.role == "act"

    def awake(self, now_s: float) -> bool:
        """Return whether a message arrived in the last AWAKE_S."""
        return 0.0 <= now_s - self.heard_s <= AWAKE_S

    def seen(self, now_s: float) -> bool:
        """Return whether a person can see the session: the page is visible, awake and draws."""
        return self.visible and self.awake(now_s) and 0.0 <= now_s - self._drawn_s <= SEEN_S

    def heard(self, now_s: float) -> None:
        """Note a message of the page; a page that slept receives everything again."""
        if not self.awake(now_s):
            self.forget_sent()
        self.heard_s = now_s

    def forget_sent(self) -> None:
        """Forget all that was sent, so that the page receives everything again."""
        self._undrawn.clear()
        self.last_bin = None
        self.tile_revision = 0
        self.tiles.clear()
        self._state_s, self._urgent = 0.0, None

    def show(self, quantities: tuple[str, ...]) -> None:
        """Set the quantities of the shown map."""
        if quantities != self.quantities:
            self.quantities, self.tile_revision = quantities, 0
            self.tiles.clear()

    def shows(self, map_number: int) -> None:
        """Set the number of the present map; a new map is sent completely."""
        if map_number != self.map_number:
            self.map_number, self.tile_revision = map_number, 0
            self.tiles.clear()

    def drew(self, now_s: float, sequence: int) -> None:
        """Note that the page has drawn a picture, which acknowledges all earlier ones."""
        while self._undrawn and self._undrawn[0] <= sequence:
            self._undrawn.popleft()
            self._drawn_s = now_s

    def has_credit(self, now_s: float, sequence: int) -> bool:
        """Return whether the picture of this sequence number may be sent; count it as skipped for lack of credit."""
        if not self.awake(now_s) or sequence == self._sequence:
            return False
        if len(self._undrawn) >= CREDIT:
            self._sequence = sequence
            self.skipped += 1
            return False
        return True

    def sent_picture(self, sequence: int, newest_bin: int) -> None:
        """Note that a picture was sent."""
        self._sequence, self.last_bin = sequence, newest_bin
        self._undrawn.append(sequence)

    def wants_state(self, now_s: float, urgent: object) -> bool:
        """Return whether a state is due."""
        if not self.awake(now_s):
            return False
        since_s = now_s - self._state_s
        return not 0.0 <= since_s < STATE_EVERY_S or (since_s >= URGENT_S and urgent != self._urgent)

    def sent_state(self, now_s: float, urgent: object) -> None:
        """Note that a state was sent."""
        self._state_s, self._urgent = now_s, urgent

    def wants_tiles(self, now_s: float, revision: int) -> bool:
        """Return whether tiles are due."""
        due = not 0.0 <= now_s - self._tiles_s < TILES_EVERY_S
        behind = bool(self.tiles) or revision != self.tile_revision
        return due and behind and self.awake(now_s) and len(self._undrawn) < CREDIT

    def next_tiles(self, now_s: float) -> list[MapTile]:
        """Take the next group of tiles to send."""
        self._tiles_s = now_s
        return [self.tiles.popleft() for _ in range(min(TILES_AT_ONCE, len(self.tiles)))]

    def answer(self, answer: dict[str, Any]) -> bool:
        """Queue an answer; return False if more than MOST_ANSWERS wait."""
        self.answers.append(answer)
        return len(self.answers) <= MOST_ANSWERS
