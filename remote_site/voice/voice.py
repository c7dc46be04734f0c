"""The voice's process: encodes what the microphone hears for all readers, and plays what the operator says."""

import logging
import os
import time
from collections import Counter
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from typing import Any

from common.config.file import load_config
from common.config.site_models import RemoteConfig
from common.config.stream_models import VoiceConfig
from common.link.curve import Received
from common.link.keys import load_keys
from common.link.local_control import LocalControlSocket
from common.link.session_state import Refused
from common.link.voice_end import VoiceEnd
from common.runtime.containment import Containment
from common.runtime.status_file import StatusFile
from common.runtime.systemd_notify import Supervisor
from common.timing.interval import Interval
from common.wire.voice_messages import FRAME_S, VoiceState
from remote_site.stream_server import LEFT_S, NICE, SECOND_S, StreamServer, make_place
from remote_site.voice.jitter_buffer import JitterBuffer
from remote_site.voice.opus_codec import OpusDecoder, OpusEncoder
from remote_site.voice.session_holder import SessionHolder
from remote_site.voice.sound_sink import SoundSink, open_sink
from remote_site.voice.sound_source import Captured, SoundSource, open_source

log = logging.getLogger(__name__)

YIELD_S = 0.5
"""Silence of the one who talks after which another may talk, s."""
_FRAME_NS = round(FRAME_S * 1e9)


@dataclass(slots=True, eq=False)
class _Reader:
    """One reader; `operates` says whether the key of its newest packet may operate the session."""

    who: bytes
    key: str
    end: VoiceEnd
    operates: bool = False


class Voice:
    """Serves one microphone and one loudspeaker. Its steps take the time, ns of the monotonic clock.

    Attributes:
        muted: whether the microphone is muted.
        counts: numbers of sounds sent, played, refused (from who may not talk, or not now) and undecodable.
    """

    def __init__(
        self,
        server: StreamServer,
        source: SoundSource,
        sink: SoundSink,
        *,
        consents: bool,
        holder: SessionHolder | None = None,
    ) -> None:
        """Serve `source` and `sink` on `server`; `consents` if the patient consents to a recording of sound.

        `holder` knows whose session it is; by default nobody's.
        """
        self.muted = False
        self.holder = holder or SessionHolder(None)
        self.counts: Counter[str] = Counter()
        self._server, self._source, self._sink, self._consents = server, source, sink, consents
        self._encoder, self._decoder, self._buffer = OpusEncoder(), OpusDecoder(), JitterBuffer()
        self._readers: dict[bytes, _Reader] = {}
        self._talker: _Reader | None = None
        self._said_ns = -(10**18)
        """When the talker's newest sound was read."""
        self._play_ns = 0

    def step(self, now_ns: int) -> None:
        """Take the readers' packets, send what is due, and play what is due."""
        for received in self._server.receive():
            self._take(received, now_ns)
        self._readers = {who: reader for who, reader in self._readers.items() if reader.end.silent_s(now_ns) < LEFT_S}
        for captured in self._source.take(now_ns):
            self._say(captured, now_ns)
        for reader in self._readers.values():
            self._send(reader, now_ns, None)
        self._play(now_ns)

    def _take(self, received: Received, now_ns: int) -> None:
        sender, packed = received
        operates = self._server.may_operate(sender.key)
        reader = self._readers.get(sender.who)
        if reader is None:
            if not make_place(self._readers, operates=operates):
                self.counts["readers refused"] += 1
                return
            reader = _Reader(sender.who, sender.key, VoiceEnd(now_ns))
        reader.operates = operates
        damaged = reader.end.counts["damaged"]
        sound = reader.end.take(packed, now_ns)
        if reader.end.counts["damaged"] > damaged:
            self.counts["damaged"] += 1
            return
        self._readers[sender.who] = reader
        if sound is None:
            return
        if not (self._may_talk(reader) and self._free_for(reader, now_ns)):
            self.counts["refused"] += 1
            return
        if self._talker is not reader:
            self._talker, self._buffer, self._decoder = reader, JitterBuffer(), OpusDecoder()
        self._said_ns = now_ns
        self._buffer.put(sound, now_ns)

    def _may_talk(self, reader: _Reader) -> bool:
        """Return whether a reader's key may operate the session, and no other operator has it."""
        return reader.operates and self.holder.admits(reader.key)

    def _free_for(self, reader: _Reader, now_ns: int) -> bool:
        """Return whether nobody else who may talk does."""
        talker = self._talker
        if talker in (None, reader) or (now_ns - self._said_ns) * 1e-9 > YIELD_S:
            return True
        return talker is not None and not self._may_talk(talker)

    def _say(self, captured: Captured, now_ns: int) -> None:
        """Encode a sound of the microphone and send it to all readers."""
        if self.muted or not self._readers:
            return
        content = self._encoder.encode(captured.samples)
        for reader in self._readers.values():
            self._send(reader, now_ns, (captured.time_ns, content))

    def _send(self, reader: _Reader, now_ns: int, sound: tuple[int, bytes] | None) -> None:
        hears = not self._sink.problem
        packed = reader.end.pack(now_ns, self.state, sound, hears=hears, consents=self._consents)
        if packed is not None:
            self._server.send(reader.who, packed)
            self.counts["sent"] += sound is not None

    def _play(self, now_ns: int) -> None:
        """Play the due sound, one in each FRAME_S."""
        if now_ns < self._play_ns:
            return
        late = now_ns - self._play_ns > 2 * _FRAME_NS
        self._play_ns = now_ns + _FRAME_NS if late else self._play_ns + _FRAME_NS
        sound = self._buffer.take(now_ns)
        if sound is None:
            return
        try:
            self._sink.play(self._decoder.decode(sound.content))
            self.counts["played"] += 1
        except ValueError as problem:
            self.counts["undecodable"] += 1
            log.debug("%s", problem)

    @property
    def state(self) -> VoiceState:
        """What the microphone does."""
        if self._source.problem:
            return VoiceState.ABSENT
        return VoiceState.MUTED if self.muted else VoiceState.TALKS

    def physician(self) -> VoiceState:
        """Return what the operator does: talks if one of the readers that may talk does."""
        states = [
            reader.end.far.state
            for reader in self._readers.values()
            if self._may_talk(reader) and reader.end.far is not None
        ]
        return min(states, default=VoiceState.ABSENT)

    def answer(self, verb: str, _: dict[str, Any] | None = None) -> dict[str, Any]:
        """Carry out a request of a person at the remote site; raises Refused where it is not for this process."""
        match verb:
            case "status":
                pass
            case "mute_voice" | "unmute_voice":
                self.muted = verb == "mute_voice"
                log.info("the microphone is %s", "muted" if self.muted else "on")
            case _:
                raise Refused(f"{verb} is not for the voice's process to do")
        return {"muted": self.muted, "physician": self.physician().name.lower()}

    def figures(self) -> dict[str, object]:
        """Return the figures for the status file."""
        recorded = self._consents and any(
            reader.end.far is not None and reader.end.far.consents for reader in self._readers.values()
        )
        return {
            "missing": self._source.problem,
            "unheard": self._sink.problem,
            **self.answer("status"),
            "recorded": recorded,
            "readers": len(self._readers),
            "dropped": self._buffer.dropped,
            "counts": dict(self.counts),
        }


def run_voice(config: VoiceConfig, stop: Callable[[], bool]) -> None:
    """Serve the remote site's voice until `stop()`.

    Raises:
        LinkProblem: a port is in use, or the address is open to a network and no key is trusted.
        KeyProblem, OSError, ValueError: the keys are damaged or missing, or source, sink or `remote` are unusable.
    """
    os.nice(NICE)
    site = None if config.remote is None else load_config(config.remote, RemoteConfig)
    consents = site is not None and site.consent is not None and site.consent.voice
    with (
        closing(StreamServer(config.link, "voice")) as server,  # first: a second start replaces no sound file
        LocalControlSocket(config.desk_port, load_keys(config.link.keys)) as desk,
        closing(open_source(config.source)) as source,
        closing(open_sink(config.sink)) as sink,
        Supervisor() as supervisor,
    ):
        holder = SessionHolder(None if site is None else site.status)
        voice = Voice(server, source, sink, consents=consents, holder=holder)
        status = StatusFile(config.status, "voice")
        supervisor.ready()
        contain, second = Containment(), Interval(SECOND_S)
        while not stop():
            server.wait(0.5 * FRAME_S)
            now_ns = time.monotonic_ns()
            voice.step(now_ns)
            desk.serve(now_ns, voice.answer)
            if second(now_s := now_ns * 1e-9):
                with contain.step("each second", latches=False):  # such as without a free file descriptor
                    server.recheck_keys()
                    holder.look(now_ns)
                    status.write(now_s, {**voice.figures(), "contained": dict(contain.places)})
                supervisor.alive(source.problem or ("muted" if voice.muted else "voice"))
