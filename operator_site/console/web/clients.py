"""One page at the other end: what it may still be sent, so that nothing queues before a slow or sleeping one.

A page may have CREDIT pictures that it has not drawn yet. It gives credit back when it has drawn one, not when one has
arrived: a page that sleeps takes messages without a limit and draws none.
"""

from collections import deque
from dataclasses import dataclass, field
from typing import Any

from operator_site.console.map.map_tiles import MapTile
from operator_site.console.web.access import Visitor

CREDIT = 2
AWAKE_S = 3.0
"""A page that said nothing for so long sleeps: it is sent nothing, and everything anew when it wakes."""
SEEN_S = 2.5
"""A page that drew nothing for so long shows nothing, whatever else it says: two heartbeats."""
STATE_EVERY_S = 0.25
URGENT_S = 0.1
"""States are sent so often, and so often at most when something in them is urgent."""
TILES_EVERY_S = 0.1
TILES_AT_ONCE = 4
MOST_ANSWERS = 100
"""Answers that wait; a page that asks more without reading is cut off."""


@dataclass(slots=True)
class Client:
    """Pure: time is an argument, s.

    Attributes:
        visitor: who it is.
        name: of this page, unique among all.
        quantity: which map it shows.
        visible: whether a person can see it, as it says.
        skipped: pictures that were not sent for want of credit.
    """

    visitor: Visitor
    name: str
    heard_s: float
    quantity: str = "temperature"
    visible: bool = True
    skipped: int = 0
    answers: deque[dict[str, Any]] = field(default_factory=deque)
    last_bin: int | None = None
    tiles: deque[MapTile] = field(default_factory=deque)
    """Tiles that are still to be sent, and the revision of the map that they lead to."""
    tile_revision: int = 0
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
        """Whether its visitor may act."""
        return self.visitor.role == "act"

    def awake(self, now_s: float) -> bool:
        """Whether it was heard lately."""
        return 0.0 <= now_s - self.heard_s <= AWAKE_S

    def seen(self, now_s: float) -> bool:
        """Whether a person can see what goes on: it is visible, awake and draws."""
        return self.visible and self.awake(now_s) and 0.0 <= now_s - self._drawn_s <= SEEN_S

    def heard(self, now_s: float) -> None:
        """It said something; one that slept is given everything anew."""
        if not self.awake(now_s):
            self.begin_anew()
        self.heard_s = now_s

    def begin_anew(self) -> None:
        """It has nothing of what was sent before."""
        self._undrawn.clear()
        self.last_bin = None
        self.tile_revision = 0
        self.tiles.clear()
        self._state_s, self._urgent = 0.0, None

    def show(self, quantity: str) -> None:
        """It shows another map now."""
        if quantity != self.quantity:
            self.quantity, self.tile_revision = quantity, 0
            self.tiles.clear()

    def shows(self, map_number: int) -> None:
        """The map that there is now; another one is sent as a whole."""
        if map_number != self.map_number:
            self.map_number, self.tile_revision = map_number, 0
            self.tiles.clear()

    def drew(self, now_s: float, sequence: int) -> None:
        """It has drawn a picture, and with it all before."""
        while self._undrawn and self._undrawn[0] <= sequence:
            self._undrawn.popleft()
            self._drawn_s = now_s

    def has_credit(self, now_s: float, sequence: int) -> bool:
        """Whether it may be sent the picture of this sequence number; counts one that it may not."""
        if not self.awake(now_s) or sequence == self._sequence:
            return False
        if len(self._undrawn) >= CREDIT:
            self._sequence = sequence
            self.skipped += 1
            return False
        return True

    def sent_picture(self, sequence: int, newest_bin: int) -> None:
        """It was sent a picture."""
        self._sequence, self.last_bin = sequence, newest_bin
        self._undrawn.append(sequence)

    def wants_state(self, now_s: float, urgent: object) -> bool:
        """Whether it is to be sent the state now."""
        if not self.awake(now_s):
            return False
        since_s = now_s - self._state_s
        return not 0.0 <= since_s < STATE_EVERY_S or (since_s >= URGENT_S and urgent != self._urgent)

    def sent_state(self, now_s: float, urgent: object) -> None:
        """It was sent the state."""
        self._state_s, self._urgent = now_s, urgent

    def wants_tiles(self, now_s: float, revision: int) -> bool:
        """Whether it is to be sent tiles now."""
        due = not 0.0 <= now_s - self._tiles_s < TILES_EVERY_S
        behind = bool(self.tiles) or revision != self.tile_revision
        return due and behind and self.awake(now_s) and len(self._undrawn) < CREDIT

    def next_tiles(self, now_s: float) -> list[MapTile]:
        """The tiles that it is sent now."""
        self._tiles_s = now_s
        return [self.tiles.popleft() for _ in range(min(TILES_AT_ONCE, len(self.tiles)))]

    def answer(self, answer: dict[str, Any]) -> bool:
        """Keep an answer for it; False when it does not read them."""
        self.answers.append(answer)
        return len(self.answers) <= MOST_ANSWERS
