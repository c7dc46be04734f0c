"""The loudspeaker: a device of ALSA written in a thread, a WAV file, or none."""

import itertools
import logging
import queue
import threading
import time
import wave
from contextlib import suppress
from pathlib import Path
from typing import Protocol

import av
import numpy as np

from common.files.private_file import create_private
from common.wire.voice_messages import RATE_HZ, SAMPLES
from remote_site.voice.alsa import use_system_alsa
from remote_site.voice.opus_codec import LAYOUT, Samples, frame_of

log = logging.getLogger(__name__)

AGAIN_S = 1.0
"""Time between two attempts to open a device, s."""
_MOST_WAITING = 4
"""Maximum number of sounds that wait for the device; further ones are dropped."""
_PAUSE_S = 0.1
"""Pause after which silence goes ahead of a sound, s: the device has run dry."""
_AHEAD = 2
"""Number of silent sounds that go ahead."""
_HANGS_S = 1.0
"""Time without the end of a write after which nobody hears the device, s."""


class SoundSink(Protocol):
    """Plays sounds; `problem` says why nobody hears them, and is empty while somebody may."""

    problem: str

    def play(self, samples: Samples) -> None:
        """Play one sound after the ones before; never blocks."""

    def close(self) -> None:
        """End it."""


class NoSink:
    """No loudspeaker."""

    problem = "there is no loudspeaker"

    def play(self, samples: Samples) -> None:
        """Play nothing."""

    def close(self) -> None:
        """End it."""


class WavSink:
    """A WAV file of all sounds, one after another without the pauses; for machines without a loudspeaker.

    Attributes:
        problem: why the newest sound is not in the file, such as a full disk; empty without a problem.
    """

    def __init__(self, path: Path) -> None:
        """Create the file; raises OSError where that is impossible."""
        self.problem = ""
        self._path = path
        self._made = create_private(path, replace=True)
        # Without a buffer, a sound that did not fit is not written again by close.
        self._file = wave.open(open(self._made.fileno(), "wb", buffering=0, closefd=False), "wb")  # noqa: SIM115
        self._file.setnchannels(1)
        self._file.setsampwidth(2)
        self._file.setframerate(RATE_HZ)

    def play(self, samples: Samples) -> None:
        """Add one sound."""
        problem = ""
        try:
            self._file.writeframes(samples.astype("<i2").tobytes())
        except OSError as error:
            problem = f"{self._path}: {error.strerror}"
        if problem and problem != self.problem:
            log.warning("nobody hears: %s", problem)
        self.problem = problem

    def close(self) -> None:
        """Close the file."""
        self._file.close()
        self._made.close()


class DeviceSink:
    """A loudspeaker of ALSA.

    Attributes:
        problem: why nobody hears anything; empty while the device plays.
    """

    def __init__(self, name: str) -> None:
        """Start writing to the device with a name such as `default`."""
        use_system_alsa()
        self.problem = "the loudspeaker was not opened yet"
        self._name = name
        self._waiting: queue.Queue[Samples | None] = queue.Queue(_MOST_WAITING)
        self._given_s = 0.0
        """When the device was given its newest sound, s of the monotonic clock."""
        self._stopping = threading.Event()
        threading.Thread(target=self._write, name="loudspeaker", daemon=True).start()

    def play(self, samples: Samples) -> None:
        """Give one sound to the device; it is dropped where too many wait, or while the device does not play."""
        if self.problem:
            return
        try:
            self._waiting.put_nowait(samples)
        except queue.Full:
            if time.monotonic() - self._given_s > _HANGS_S:
                self._lost("takes no sound")

    def close(self) -> None:
        """End the thread with its next sound or error, without waiting for it."""
        self._stopping.set()
        with suppress(queue.Full):
            self._waiting.put_nowait(None)

    def _write(self) -> None:
        while not self._stopping.is_set():
            try:
                with av.open(self._name, "w", format="alsa") as container:
                    self._play_all(container)
            except Exception as error:  # of any kind: without this thread nothing is heard any more
                self._lost(getattr(error, "strerror", None) or str(error))
            self._stopping.wait(AGAIN_S)

    def _lost(self, why: str) -> None:
        problem = f"alsa:{self._name}: {why}"
        if problem != self.problem:
            log.warning("nobody hears: %s", problem)
        self.problem = problem
        self._waiting = queue.Queue(_MOST_WAITING)  # what waits now is old when the device comes back

    def _play_all(self, container: av.container.OutputContainer) -> None:
        stream = container.add_stream("pcm_s16le", rate=RATE_HZ, layout=LAYOUT)
        container.start_encoding()  # opens the device
        numbers, played_s = itertools.count(), 0.0
        self.problem = ""
        while (samples := self._waiting.get()) is not None and not self._stopping.is_set():
            self._given_s = time.monotonic()
            dry = self._given_s - played_s > _PAUSE_S
            for block in [np.zeros(SAMPLES, np.int16)] * (_AHEAD if dry else 0) + [samples]:
                container.mux(stream.encode(frame_of(block, next(numbers))))
            played_s, self.problem = time.monotonic(), ""


def open_sink(place: str | Path) -> SoundSink:
    """Open a sink of the configuration.

    Raises:
        ValueError, OSError: it is no device and no file that can be created.
    """
    if isinstance(place, Path):
        if place.suffix.lower() != ".wav":
            raise ValueError(f"sink {place}: a file has to end in .wav")
        return WavSink(place)
    kind, _, name = place.partition(":")
    if kind == "alsa":
        return DeviceSink(name or "default")
    if place != "none":
        raise ValueError(f"sink {place!r}: expected such as alsa:default, a WAV file or none")
    return NoSink()
