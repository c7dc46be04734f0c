"""Cost of the voice: reference steps and bits of each sound, and time from mouth to ear without browser and devices.

`python -m benchmarks.voice_cost.run` prints two tables. The way from mouth to ear is over real Curve on loopback: the
voice's process says a tone, and the console's end receives it.
"""

import itertools
import time
from collections.abc import Callable
from contextlib import closing
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.runtime_cost.measure import timed
from common.config.link_models import RemoteLinkConfig
from common.link.keys import TrustedKeys, create_keys, load_keys
from common.runtime.reference_step import reference_step
from common.wire.voice_messages import FRAME_S, VoicePacket, VoiceState
from operator_site.console.stream_socket import StreamSocket
from operator_site.console.voice.voice import Talk, Voice
from remote_site.stream_server import StreamServer
from remote_site.voice import voice as remote_voice
from remote_site.voice.opus_codec import OpusDecoder, OpusEncoder
from remote_site.voice.sound_sink import NoSink
from remote_site.voice.sound_source import open_source, tone

SECONDS = 20.0
_SOUNDS = 500
_PORT = 47_600
_LOOK_S = 0.008
"""Interval between two steps of the console, s."""


def coding() -> list[tuple[str, float]]:
    """Return name and cost of each operation, in reference steps (median)."""
    encoder, decoder = OpusEncoder(), OpusDecoder()
    blocks = list(itertools.islice(tone(440.0), _SOUNDS))
    coded = [encoder.encode(samples) for samples in blocks]
    now_ns = time.monotonic_ns()
    packet = VoicePacket(1 << 61, 1 << 16, now_ns, now_ns, now_ns, now_ns, VoiceState.TALKS, True, False, coded[0])
    packed = packet.encode()
    works: list[tuple[str, Callable[[int], object]]] = [
        ("encode a sound", lambda number: encoder.encode(blocks[number])),
        ("decode a sound", lambda number: decoder.decode(coded[number])),
        ("pack and unpack a packet", lambda number: VoicePacket.decode(packet.encode())),
    ]
    found = []
    for name, work in works:
        pairs = [(timed(partial(work, number)), timed(reference_step)) for number in range(_SOUNDS)]
        work_ns, step_ns = np.median(np.array(pairs), axis=0)
        found.append((name, float(work_ns / step_ns)))
    size = 8.0 / FRAME_S / 1e3
    found.append(("sound, kbit/s", len(coded[0]) * size))
    found.append(("packets, kbit/s", len(packed) * size))
    return found


def mouth_to_ear() -> list[float]:
    """Return the age of each sound when the console has it, s."""
    ages_s: list[float] = []
    with TemporaryDirectory() as folder:
        here, there = Path(folder) / "operator", Path(folder) / "remote"
        public, remote_public = create_keys(here), create_keys(there)
        TrustedKeys(there).trust("operator", public)
        with closing(StreamServer(RemoteLinkConfig(base_port=_PORT, keys=there), "voice")) as server:
            process = remote_voice.Voice(server, open_source("tone:440"), NoSink(), consents=False)
            line = StreamSocket("voice", "127.0.0.1", _PORT, load_keys(here), remote_public)
            with closing(Voice(line)) as console:
                end_s = time.monotonic() + SECONDS
                look_s = 0.0
                while (now_s := time.monotonic()) < end_s:
                    process.step(time.monotonic_ns())
                    if now_s >= look_s:
                        look_s = now_s + _LOOK_S
                        ages_s += [time.monotonic() - sound.captured_s for sound in console.step(1, Talk())]
                    time.sleep(0.002)
    return ages_s


if __name__ == "__main__":
    print("| what | reference steps, or kbit/s |\n|---|---|")
    for name, value in coding():
        print(f"| {name} | {value:.2f} |")
    ages_ms = 1e3 * np.array(mouth_to_ear())
    middle_ms, late_ms = np.quantile(ages_ms, (0.5, 0.99))
    print(f"age of {len(ages_ms)} sounds at the console: 50 % {middle_ms:.1f} ms, 99 % {late_ms:.1f} ms")
