"""Follows the remote site's camera: one step reads what has arrived and answers it."""

import time
from collections.abc import Callable

from operator_site.console.camera.camera_now import CameraNow
from operator_site.console.camera.camera_picture import Picture
from operator_site.console.camera.picture_reader import PictureReader
from operator_site.console.stream_socket import Reconnection, StreamSocket

_AT_ONCE = 16
"""Maximum number of messages of one step."""


class Camera:
    """The remote site's camera as the console sees it."""

    def __init__(
        self, line: StreamSocket, *, required: bool = False, clock_ns: Callable[[], int] = time.monotonic_ns
    ) -> None:
        """Read `line`.

        Args:
            required: whether the session pauses without a live picture.
        """
        self._line, self._clock_ns = line, clock_ns
        self._reader = PictureReader(clock_ns(), required=required)
        self._reconnection = Reconnection(line, clock_ns())
        self.clock = self._reader.clock
        """Comparison with the camera's clock."""

    def step(self, session: int, touch_age_s: float, *, wants_key: bool) -> list[Picture]:
        """Return the arrived pictures that can be decoded, oldest first, and send the due packet."""
        found = []
        for _ in range(_AT_ONCE):
            if not (parts := self._line.receive()):
                break
            if (picture := self._reader.take(parts, self._clock_ns())) is not None:
                found.append(picture)
        now_ns = self._clock_ns()
        self._reconnection.step(now_ns, self._reader.silent_s(now_ns))
        if (ask := self._reader.ask(self._clock_ns(), session, touch_age_s, wants_key=wants_key)) is not None:
            self._line.send(ask.encode())
        return found

    @property
    def now(self) -> CameraNow:
        """What is seen now."""
        return self._reader.now(self._clock_ns(), refused=self._line.refused)

    def figures(self) -> dict[str, object]:
        """Return the values for the status file."""
        now, clock = self.now, self.clock.own
        return {
            "camera": str(now.seen),
            "camera_age_s": round(now.age_s, 3),
            "camera_damaged": self._reader.damaged,
            "camera_clock_uncertainty_us": None if clock.uncertainty_ns is None else clock.uncertainty_ns // 1000,
        }

    def close(self) -> None:
        """Disconnect."""
        self._line.close()
