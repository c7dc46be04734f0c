"""The camera's process: take the newest picture, encode it, send it to readers with credit."""

import logging
import os
import time
from collections import Counter
from collections.abc import Callable
from contextlib import closing

from common.config.stream_models import CameraConfig
from common.link.curve import Received
from common.runtime.containment import Containment
from common.runtime.status_file import StatusFile
from common.runtime.systemd_notify import Supervisor
from common.timing.interval import Interval
from common.wire.camera_messages import ASK_S, MAX_PICTURE, CameraAsk, CameraState, PictureHeader
from common.wire.packets import BadPacket
from remote_site.camera.picture_ladder import LEAST_HZ, PictureLadder
from remote_site.camera.picture_readers import PictureReaders, Reader
from remote_site.camera.video_encoder import VideoEncoder
from remote_site.camera.video_source import Captured, VideoSource
from remote_site.stream_server import NICE, SECOND_S, StreamServer

log = logging.getLogger(__name__)

_EARLY = 0.5
"""Share of a period by which a picture may come early, because the source's rate varies."""


class Camera:
    """Serves pictures of one source. Its steps take the time, ns of the monotonic clock.

    Attributes:
        counts: numbers of pictures sent and left out, of refused readers, and of packets that could not be read.
    """

    def __init__(self, config: CameraConfig, link: StreamServer, source: VideoSource) -> None:
        self._config, self._link, self._source = config, link, source
        self._ladder, self._readers = PictureLadder(), PictureReaders()
        self._encoder: VideoEncoder | None = None
        self._rung = -1
        self._sequence = 0
        self._due_ns = 0
        self._newest_ns = 0
        self.counts: Counter[str] = Counter()
        self._bytes = 0

    def step(self, now_ns: int) -> None:
        """Take the readers' packets and the newest picture; send what is due."""
        now_s = now_ns * 1e-9
        for received in self._link.receive():
            self._take(received, now_ns)
        self._readers.drop_absent(now_s)
        if (captured := self._source.take()) is not None:
            self._newest_ns = captured.time_ns
            self._show(captured, now_ns)

    def _take(self, received: Received, now_ns: int) -> None:
        """Take a reader's packet, and answer it with the clock and the state."""
        sender, packet = received
        try:
            ask = CameraAsk.decode(packet)
        except BadPacket as problem:
            self.counts["bad packets"] += 1
            log.debug("a reader's packet: %s", problem)
            return
        reader = self._readers.take(sender.who, self._link.may_operate(sender.key), ask, now_ns)
        if reader is None:
            self.counts["readers refused"] += 1
            return
        if reader.operates:
            self._ladder.step(now_ns * 1e-9, ask.touch_age_us * 1e-6, ask.picture_age_us * 1e-6)
        self._send(reader, self._header(reader, self._newest_ns, is_key=False), b"")

    def _show(self, captured: Captured, now_ns: int) -> None:
        """Encode and send a picture if it is due and a reader has credit."""
        rung = self._ladder.rung
        rate_hz = self._config.rate_hz
        period_ns = round(1e9 / max(rate_hz * rung.rate, min(rate_hz, LEAST_HZ)))
        now_s = now_ns * 1e-9
        ready = self._readers.ready(now_s)
        if not ready or captured.time_ns < self._due_ns:
            return
        self._due_ns = max(self._due_ns + period_ns, captured.time_ns + round(_EARLY * period_ns))
        encoder = self._encoder
        if encoder is None or self._rung != self._ladder.number:
            encoder = self._encoder = self._open(period_ns)
        encoded = encoder.encode(captured.frame, captured.time_ns, self._readers.key_is_due(now_s, ready))
        if encoded is None:
            self.counts["pictures left out"] += 1
            return
        self._sequence += 1
        fits = len(encoded.data) <= MAX_PICTURE  # otherwise no reader gets it, and all need a key picture
        for reader in self._readers.sent(self._sequence, now_s, encoded.is_key, ready if fits else []):
            self._send(reader, self._header(reader, captured.time_ns, encoded.is_key), encoded.data)
            self.counts["pictures"] += 1
            self._bytes += len(encoded.data)

    def _open(self, period_ns: int) -> VideoEncoder:
        """Return an encoder for the present rung."""
        rung, config = self._ladder.rung, self._config
        self._rung = self._ladder.number
        width, height = (max(16, 2 * round(0.5 * side * rung.size)) for side in (config.width, config.height))
        return VideoEncoder(width, height, 1e9 / period_ns, round(config.bit_s * rung.bits))

    def _header(self, reader: Reader, captured_ns: int, is_key: bool) -> PictureHeader:
        state = CameraState.GIVES_WAY if self._ladder.number else CameraState.SHOWING
        if self._source.problem:
            state = CameraState.NO_CAMERA
        encoder = self._encoder
        return PictureHeader(
            session=0,
            sequence=self._sequence,
            time_ns=captured_ns,
            sent_ns=time.monotonic_ns(),
            asked_ns=reader.asked_ns,
            heard_ns=reader.heard_ns,
            state=state,
            rung=self._ladder.number,
            is_key=is_key,
            width=self._config.width if encoder is None else encoder.width,
            height=self._config.height if encoder is None else encoder.height,
        )

    def _send(self, reader: Reader, header: PictureHeader, picture: bytes) -> None:
        self._link.send(reader.who, header.encode(), picture)

    def figures(self) -> dict[str, object]:
        """Return the figures for the status file."""
        return {
            "missing": self._source.problem or self._source.repeats,
            "readers": len(self._readers.present),
            "rung": self._ladder.number,
            "sequence": self._sequence,
            "bytes": self._bytes,
            "counts": dict(self.counts),
        }


def run_camera(config: CameraConfig, stop: Callable[[], bool]) -> None:
    """Serve the remote site's camera until `stop()`.

    Raises:
        LinkProblem: the port of the stream is in use, or the address is open to a network and no key is trusted.
        KeyProblem, OSError: the keys are damaged or missing.
    """
    os.nice(NICE)
    source = VideoSource(config.source, (config.width, config.height), config.rate_hz, config.delay_s)
    with closing(source), closing(StreamServer(config.link, "camera")) as link, Supervisor() as supervisor:
        camera = Camera(config, link, source)
        status = StatusFile(config.status, "camera")
        supervisor.ready()
        contain, second = Containment(), Interval(SECOND_S)
        while not stop():
            link.wait(ASK_S, source.news.fileno())
            camera.step(time.monotonic_ns())
            if second(now_s := time.monotonic()):
                with contain.step("each second", latches=False):  # such as without a free file descriptor
                    link.recheck_keys()
                    status.write(now_s, {**camera.figures(), "contained": dict(contain.places)})
                supervisor.alive(source.problem or source.repeats or "pictures")
