"""A console with a voice: it relays both ways, shows both ends, and records only where both sides agree."""

import asyncio
from pathlib import Path
from unittest.mock import Mock

import pytest

from common.config.page_models import ConsoleConfig, ConsoleVoiceConfig
from common.config.recording_models import ConsentConfig
from common.link.voice_end import VoiceEnd
from common.recording.reader import RecordingReader
from common.wire.voice_messages import VoicePacket, VoiceState
from operator_site.console.examination.journal import Journal
from operator_site.console.live import LiveConsole
from operator_site.console.voice.voice import Voice
from operator_site.console.voice.voice_now import Heard
from operator_site.console.voice.voice_sound import VoiceSound
from operator_site.console.web.page_state import page_state
from operator_site.session.console_feed import Fed
from tests.unit.operator_site.console.fed import figures, rendered
from tests.unit.operator_site.console.page_room import AnsweringSite

S = 1_000_000_000
CONSENT = ConsentConfig(touch=True, pain=True, voice=True)
AHEAD_S = 5.0
"""Lead of the site's clock, s."""
WAY_NS = 10_000_000


class Line:
    """A connection with a far end in memory; each packet takes 10 ms."""

    refused = False

    def __init__(self, work: "Work") -> None:
        self._work = work
        self.end = VoiceEnd(0)
        self.heard: list[VoicePacket] = []
        self.waiting: list[tuple[int, bytes]] = []

    def receive(self) -> list[bytes]:
        if self.waiting and self.waiting[0][0] <= self._work.now_ns:
            return [self.waiting.pop(0)[1]]
        return []

    def send(self, packet: bytes) -> None:
        self.end.take(packet, self._work.now_ns + WAY_NS)
        self.heard.append(VoicePacket.decode(packet))

    def say(self, content: bytes, *, consents: bool) -> None:
        now_ns = self._work.now_ns
        sound = (now_ns - 20_000_000, content)
        packed = self.end.pack(now_ns, VoiceState.TALKS, sound, hears=True, consents=consents)
        if packed is not None:
            self.waiting.append((now_ns + WAY_NS, packed))

    def reconnect(self) -> None:
        pass

    def close(self) -> None:
        pass


class Work:
    """A console on a clock of the test, and a voice whose clock is the console's."""

    def __init__(self, path: Path, *, record: bool) -> None:
        self.now_s, self.line, self.journal = 100.0, Line(self), Journal(path, {})
        config = ConsoleConfig(keys=Path(), record=path, voice=ConsoleVoiceConfig(record=record), consent=CONSENT)
        voice = Voice(self.line, record=record, clock_ns=lambda: self.now_ns)
        self.live = LiveConsole(config, self, AnsweringSite(), self.journal, lambda: self.now_s, voice=voice)

    @property
    def now_ns(self) -> int:
        return round(self.now_s * S)

    def receive(self) -> list[Fed]:
        site_ns = round((self.now_s + AHEAD_S) * S)
        return [Fed("operator/figures", site_ns, figures()), Fed("operator/rendered", site_ns, rendered())]

    async def go(self, seconds: float, *, consents: bool = False, talks: bool = False) -> None:
        """Let time pass in steps of 20 ms, each with a sound of the remote site, and of a page that `talks`."""
        for number in range(round(seconds / 0.02)):
            self.now_s += 0.02
            self.line.say(b"far", consents=consents)
            self.live.step(self.now_s)
            if talks:
                self.live._say(VoiceSound("to_remote", number, self.now_s - 0.03, 0.001, b"near"))
            await asyncio.sleep(0.0)

    def recorded(self) -> list[tuple[int, VoiceSound]]:
        self.journal.close()
        path = self.journal.files[0]
        with path.open("rb") as file:
            messages = RecordingReader(path, file).messages(["console/voice"])
            return [(one.log_time, VoiceSound.of_record(one.data)) for _, _, one in messages]


def test_both_ends_are_shown(tmp_path: Path) -> None:
    async def watch() -> None:
        work = Work(tmp_path / "console.mcap", record=False)
        await work.go(1.0)
        now = work.live.console.around.voice
        assert now is not None
        assert (now.heard, now.hears, now.recorded, now.talker) == (Heard.LIVE, True, False, "")
        state = page_state(work.live.console, work.now_s, lambda _: True, "")
        assert state["voice"] == {"heard": "live", "hears": True, "recorded": False, "talker": ""}
        assert work.line.heard[-1].state is VoiceState.ABSENT
        work.line.waiting.clear()
        work.now_s += 2.0
        work.live.step(work.now_s)
        assert work.live.console.around.voice is not None
        assert work.live.console.around.voice.heard is Heard.SILENT
        assert work.live.figures()["voice"] == "silent"
        assert [alarm for alarm in work.live.console.alarms.listed if "oice" in alarm.text] == []
        work.journal.close()

    asyncio.run(watch())


@pytest.mark.parametrize("record", [False, True])
@pytest.mark.parametrize("consents", [False, True])
def test_sound_is_recorded_only_where_both_sides_agree(tmp_path: Path, record: bool, consents: bool) -> None:
    async def watch() -> None:
        work = Work(tmp_path / "console.mcap", record=record)
        await work.go(1.0, consents=consents)
        await work.go(1.0, consents=consents, talks=True)
        assert sum(packet.sound == b"near" for packet in work.line.heard) == 50
        kept = work.recorded()
        assert bool(kept) == (record and consents)
        if kept:
            assert {sound.direction for _, sound in kept} == {"from_remote", "to_remote"}
            assert sum(sound.direction == "to_remote" for _, sound in kept) == 50
        for time_ns, sound in kept:
            old_s = 0.03 if sound.direction == "to_remote" else 0.04
            assert time_ns * 1e-9 - sound.captured_s == pytest.approx(old_s, abs=sound.uncertainty_s + 1e-6)
            assert sound.uncertainty_s <= 0.016

    asyncio.run(watch())


def test_a_site_that_was_never_heard_has_no_silence_in_seconds() -> None:
    config, journal = ConsoleConfig(keys=Path()), Journal(None, {})
    live = LiveConsole(config, Mock(receive=lambda: []), AnsweringSite(), journal, lambda: 100.0)
    assert live.figures()["stale"] == "no message from the operator site yet"
    live.console.take("operator/figures", 98 * S, figures())
    assert live.figures()["stale"] == "no message from the operator site for 2.0 s"
    live.console.take("operator/figures", 100 * S, figures())
    assert live.figures()["stale"] == ""
