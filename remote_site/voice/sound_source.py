"""The microphone: a device of ALSA read in a thread, a sound file that is repeated, or a tone."""

import itertools
import logging
import threading
import time
from collections import deque
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple, Protocol

import av
import numpy as np
from av.error import FFmpegError

from common.wire.voice_messages import FRAME_S, RATE_HZ, SAMPLES
from remote_site.voice.alsa import use_system_alsa
from remote_site.voice.opus_codec import FORMAT, LAYOUT, Samples

log = logging.getLogger(__name__)

LOUDNESS = 0.1
"""Amplitude of the tone, as a share of full scale."""
AGAIN_S = 1.0
"""Time between two attempts to open a device, s."""
_FRAME_NS = round(FRAME_S * 1e9)
_MOST_WAITING = 4
"""Maximum number of sounds of a device that wait for the loop; further ones replace the oldest."""
_HANGS_NS = 1_000_000_000
"""Time without a sound after which a device gives none, ns; one that works gives silence, too."""
_BEHIND = 10
"""Number of sounds by which a paced source may be late; it then drops the rest."""


class Captured(NamedTuple):
    """One sound with the time of its first sample, ns of the monotonic clock."""

    time_ns: int
    samples: Samples


class SoundSource(Protocol):
    """A source of sounds; `problem` says why there are none, and is empty while there are some."""

    problem: str

    def take(self, now_ns: int) -> list[Captured]:
        """Return the sounds since the last call."""

    def close(self) -> None:
        """End it."""


class PacedSource:
    """Sounds that are made or read in advance, one in each FRAME_S."""

    problem = ""

    def __init__(self, blocks: Iterator[Samples]) -> None:
        """Begin at the first call of `take`."""
        self._blocks = blocks
        self._next_ns: int | None = None

    def take(self, now_ns: int) -> list[Captured]:
        """Return the sounds that have ended since the last call."""
        if self._next_ns is None:
            self._next_ns = now_ns
        self._next_ns = max(self._next_ns, now_ns - _BEHIND * _FRAME_NS)
        found = []
        while self._next_ns + _FRAME_NS <= now_ns:
            found.append(Captured(self._next_ns, next(self._blocks)))
            self._next_ns += _FRAME_NS
        return found

    def close(self) -> None:
        """End it."""


class DeviceSource:
    """A microphone of ALSA.

    Attributes:
        problem: why there is no sound; empty while there is some.
    """

    def __init__(self, name: str) -> None:
        """Start reading the device with a name such as `default`."""
        use_system_alsa()
        self.problem = "the microphone was not opened yet"
        self._name = name
        self._found: deque[Captured] = deque(maxlen=_MOST_WAITING)
        self._heard_ns = 0
        """When the newest sound came, ns of the monotonic clock."""
        self._stopping = threading.Event()
        threading.Thread(target=self._read, name="microphone", daemon=True).start()

    def take(self, now_ns: int) -> list[Captured]:
        """Return the sounds since the last call."""
        found = []
        with suppress(IndexError):
            while True:
                found.append(self._found.popleft())
        if not self.problem and now_ns - self._heard_ns > _HANGS_NS:
            self._lost(f"alsa:{self._name}: gives no sound")
        return found

    def close(self) -> None:
        """End the thread with its next sound or error, without waiting for it."""
        self._stopping.set()

    def _read(self) -> None:
        while not self._stopping.is_set():
            try:
                options = {"sample_rate": str(RATE_HZ), "channels": "1"}
                with av.open(self._name, format="alsa", options=options) as container:
                    for samples in _blocks(container):
                        if self._stopping.is_set():
                            return
                        self._heard_ns, self.problem = time.monotonic_ns(), ""
                        self._found.append(Captured(self._heard_ns - _FRAME_NS, samples))
                self._lost("the microphone has ended")
            except Exception as error:  # of any kind: without this thread nothing is heard any more
                self._lost(f"alsa:{self._name}: {getattr(error, 'strerror', None) or error}")
            self._stopping.wait(AGAIN_S)

    def _lost(self, problem: str) -> None:
        if problem != self.problem:
            log.warning("no sound: %s", problem)
        self.problem = problem


def open_source(place: str | Path) -> SoundSource:
    """Open a source of the configuration; raises ValueError where it is no tone, or no file with sound."""
    if isinstance(place, Path):
        return PacedSource(_repeated(place))
    kind, _, name = place.partition(":")
    if kind == "alsa":
        return DeviceSource(name or "default")
    try:
        hz = float(name)
    except ValueError:
        hz = 0.0
    if kind != "tone" or not 20.0 <= hz <= 20_000.0:
        raise ValueError(f"source {place!r}: expected such as tone:440, alsa:default or a sound file")
    return PacedSource(tone(hz))


def tone(hz: float) -> Iterator[Samples]:
    """Yield a quiet tone without end, without steps between the sounds."""
    for number in itertools.count():
        at_s = (number * SAMPLES + np.arange(SAMPLES)) / RATE_HZ
        yield np.round(32767.0 * LOUDNESS * np.sin(2.0 * np.pi * hz * at_s)).astype(np.int16)


def _repeated(path: Path) -> Iterator[Samples]:
    """Return the sounds of a file without end; raises ValueError where it has none."""
    try:
        with av.open(path) as container:
            empty = next(_blocks(container), None) is None
    except (FFmpegError, OSError, ValueError) as error:
        raise ValueError(f"source {path}: {getattr(error, 'strerror', None) or error}") from None
    if empty:
        raise ValueError(f"source {path}: has no sound of {1e3 * FRAME_S:g} ms")
    return itertools.chain.from_iterable(_file(path) for _ in itertools.count())


def _file(path: Path) -> Iterator[Samples]:
    with av.open(path) as container:
        yield from _blocks(container)


def _blocks(container: av.container.InputContainer) -> Iterator[Samples]:
    """Yield the sounds of a container; the rest that fills no sound is left out."""
    if not container.streams.audio:
        raise ValueError("has no sound")
    resampler = av.AudioResampler(format=FORMAT, layout=LAYOUT, rate=RATE_HZ, frame_size=SAMPLES)
    for frame in container.decode(audio=0):
        for block in resampler.resample(frame):
            yield block.to_ndarray().reshape(-1).astype(np.int16, copy=False)
