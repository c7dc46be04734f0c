"""Evens out the arrival of sounds: holds a few back, and drops those for which there is no time."""

from collections import deque

from common.link.voice_end import Sound, is_old
from common.wire.voice_messages import FRAME_S

FIRST = 3
"""Number of sounds that wait before the first one is played, after each pause: 60 ms."""
MOST = 8
"""Maximum number of sounds that wait: 160 ms. One more drops the oldest ones, until FIRST wait."""
CALM = 100
"""Number of played sounds after which one is dropped if more than FIRST waited all the time: 2 s."""
PATIENCE_S = 0.1
"""Time after which fewer than FIRST sounds are played, too, s: nothing more comes."""


class JitterBuffer:
    """Buffer of one talker. Pure: time is an argument, ns.

    Attributes:
        dropped: number of sounds that were dropped.
    """

    def __init__(self) -> None:
        self.dropped = 0
        self._waiting: deque[Sound] = deque()
        self._playing = False
        self._arrived_ns = 0
        self._played_ns = -(10**18)
        """Time of the newest played sound."""
        self._least, self._count = MOST, 0

    def put(self, sound: Sound, now_ns: int) -> None:
        """Take a sound; sounds come in the order of their times."""
        self._waiting.append(sound)
        self._arrived_ns = now_ns
        if len(self._waiting) > MOST:
            self._drop(len(self._waiting) - FIRST)

    def take(self, now_ns: int) -> Sound | None:
        """Return the sound to play now, or None for silence; call it every FRAME_S."""
        while self._waiting and (
            is_old(self._waiting[0].captured_ns, now_ns) or self._waiting[0].captured_ns <= self._played_ns
        ):
            self._drop(1)
        waits = len(self._waiting)
        enough = waits >= FIRST or (now_ns - self._arrived_ns) * 1e-9 >= PATIENCE_S
        if not waits or not (self._playing or enough):
            self._playing = False
            return None
        if not self._playing:
            self._playing, self._least, self._count = True, MOST, 0
        self._trim(waits)
        sound = self._waiting.popleft()
        self._played_ns = sound.captured_ns
        return sound

    def _trim(self, waits: int) -> None:
        """Drop one sound if there were more than needed for a while."""
        self._least, self._count = min(self._least, waits), self._count + 1
        if self._count >= CALM:
            if self._least > FIRST:
                self._drop(1)
            self._least, self._count = MOST, 0

    def _drop(self, count: int) -> None:
        for _ in range(count):
            self._waiting.popleft()
        self.dropped += count


LONGEST_S = MOST * FRAME_S
"""Longest time that a sound waits in the buffer, s, where one is taken every FRAME_S."""
