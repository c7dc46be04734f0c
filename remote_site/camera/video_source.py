"""Reads a camera in a thread, and keeps only its newest picture.

PyAV opens what FFmpeg opens: V4L2 devices, RTSP, HTTP and TCP addresses.
"""

import logging
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from typing import Any, NamedTuple

import av
from av.format import Flags

from remote_site.camera.picture_lag import PictureLag

log = logging.getLogger(__name__)

AGAIN_S = 1.0
"""Time between two attempts to open the camera, s."""
_OPEN_S, _SILENT_S = 5.0, 2.0
"""Longest wait for a camera that opens, and for its next picture, s."""
_HANGS_S = 3.0
"""Time without a picture after which a camera counts as lost, s; a driver that hangs ends no wait."""
_REPEATS_S = 3.0
"""Time of the same bytes again and again after which no picture counts as new, s: every sensor has noise."""
_LATE_S = 2.0
"""Lag of the pictures, s, and time for which it lasts, after which the camera is opened again: old ones then drop."""
_COUNTED = "yuv4mpegpipe"
"""Format of cameras at `tcp:` addresses, which has no time stamps: the library only counts its pictures."""
_BEHIND_S = 0.5
"""Time after opening in which pictures are dropped, s: the library read them to learn the format."""


class Captured(NamedTuple):
    """A picture with its time of capture, ns of the monotonic clock."""

    time_ns: int
    frame: av.VideoFrame


class VideoSource:
    """The newest picture of a camera.

    Attributes:
        news: socket that becomes readable at each new picture.
        problem: why there is no picture; empty while there is one.
        repeats: that the camera sends one picture again and again, which is no new one; empty while it does not.
    """

    def __init__(self, source: str, size: tuple[int, int], rate_hz: float, delay_s: float) -> None:
        """Start reading.

        Args:
            source: a video device such as `/dev/video0`, or an address.
            size: width and height that a video device is asked for, pixels.
            rate_hz: rate that a video device is asked for, Hz.
            delay_s: time from the exposure to the arrival of a picture, s.
        """
        self.problem, self.repeats = "the camera was not opened yet", ""
        self.news, self._wake = socket.socketpair()
        self.news.setblocking(False)
        self._wake.setblocking(False)
        self._source, self._delay_ns = source, round(delay_s * 1e9)
        self._options = {"fflags": "nobuffer", "flags": "low_delay", "analyzeduration": "0"}
        self._format = None
        if source.startswith("/dev/"):
            self._format = "v4l2"
            self._options = {"video_size": f"{size[0]}x{size[1]}", "framerate": f"{rate_hz:g}"}
        elif source.startswith("tcp:"):
            self._format = _COUNTED
        self._newest: Captured | None = None
        self._arrived_s = 0.0
        """When the newest picture came, s of the monotonic clock."""
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._read, name="camera", daemon=True)
        self._thread.start()

    def take(self) -> Captured | None:
        """Return the newest picture, once; None where there is no new one."""
        with suppress(BlockingIOError):
            self.news.recv(4096)
        newest, self._newest = self._newest, None
        if not self.problem and time.monotonic() - self._arrived_s > _HANGS_S:
            self._lost(f"{self._source}: sends no picture")
        return newest

    def close(self) -> None:
        """End the thread with its next picture or error, without waiting for it."""
        self._stopping.set()
        self.news.close()

    def _read(self) -> None:
        with self._wake:
            while not self._stopping.is_set():
                try:
                    self._read_pictures()
                    self._lost("the camera has ended its pictures")
                except Exception as error:  # of any kind: without this thread there are no more pictures
                    self._lost(f"{self._source}: {getattr(error, 'strerror', None) or error}")
                self._stopping.wait(AGAIN_S)

    def _lost(self, problem: str) -> None:
        if problem != self.problem:
            log.warning("no picture: %s", problem)
        self.problem = problem

    def _read_pictures(self) -> None:
        keywords: dict[str, Any] = {"options": self._options, "timeout": (_OPEN_S, _SILENT_S)}
        with av.open(self._source, format=self._format, **keywords) as container:
            if not container.streams.video:
                raise ValueError("has no pictures")
            stamped = self._format != _COUNTED and not container.format.flags & Flags.no_timestamps.value
            lag, lag_s, opened_s = PictureLag(), 0.0, time.monotonic()
            timely_s = opened_s
            for frame in self._decoded(container):
                now_ns = time.monotonic_ns()
                now_s = now_ns * 1e-9
                if self._stopping.is_set():
                    return
                if stamped and frame.time is not None:
                    lag_s = lag.take(now_s, frame.time)
                if lag_s <= _LATE_S:
                    timely_s = now_s
                elif now_s - timely_s > _LATE_S:
                    raise ValueError(f"its pictures stay more than {_LATE_S:g} s late")
                if now_s - opened_s < _BEHIND_S:
                    continue
                self._arrived_s, self.problem = now_s, ""
                if self.repeats:
                    continue
                self._newest = Captured(now_ns - self._delay_ns - round(lag_s * 1e9), frame)
                with suppress(OSError):  # full, or closed on the other side
                    self._wake.send(b"\0")

    def _decoded(self, container: Any) -> Iterator[av.VideoFrame]:
        """Decode all pictures, and note when the camera begins and ends to repeat one."""
        newest, since_s = b"", 0.0
        for packet in container.demux(video=0):
            if (content := bytes(packet)) != newest:
                newest, since_s, self.repeats = content, time.monotonic(), ""
            elif not self.repeats and time.monotonic() - since_s > _REPEATS_S:
                self.repeats = f"{self._source}: repeats one picture"
                log.warning("no new picture: %s", self.repeats)
            yield from packet.decode()
