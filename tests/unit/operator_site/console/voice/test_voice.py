"""The console's end of the stream `voice` over real Curve: both ways, loss, restart, refused key, damage, silence."""

from collections.abc import Iterator

import pytest

from common.link.keys import TrustedKeys, load_keys
from common.wire.voice_messages import VoiceState
from operator_site.console.stream_socket import StreamSocket
from operator_site.console.voice.voice import Talk, Voice
from operator_site.console.voice.voice_now import Heard
from operator_site.console.voice.voice_sound import VoiceSound
from tests.conftest import Keys
from tests.unit.operator_site.console.voice.fake_voice import FakeVoice, until

pytestmark = pytest.mark.timeout(60)

CONTENT = b"opus"


class Both:
    """A voice's process and the console's end on one machine."""

    def __init__(self, base_port: int, keys: Keys, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr("operator_site.console.stream_socket.RECONNECT_S", 0.3)
        self._port, self._keys = base_port, keys
        self.process: FakeVoice | None = None
        self.talk = Talk()
        remote = load_keys(keys.remote).public
        line = StreamSocket("voice", "127.0.0.1", base_port, load_keys(keys.operator), remote)
        self.voice = Voice(line, record=True)
        self.taken: list[VoiceSound] = []

    def start(self) -> FakeVoice:
        self.process = FakeVoice(self._port, self._keys)
        return self.process

    def end(self) -> None:
        if self.process is not None:
            self.process.close()
        self.process = None

    def step(self) -> None:
        self.taken += self.voice.step(7, self.talk)
        if self.process is not None:
            self.process.turn()

    def hears(self, heard: Heard) -> bool:
        self.step()
        return self.voice.now.heard is heard

    def took(self, count: int) -> bool:
        """Whether as many sounds have come, of which the process says one after the other."""
        if self.process is not None:
            self.process.say(CONTENT)
        self.step()
        return len(self.taken) >= count

    def damaged(self) -> int:
        self.step()
        counts = self.voice.figures()["voice_counts"]
        assert isinstance(counts, dict)
        return int(counts.get("damaged", 0))

    def close(self) -> None:
        self.end()
        self.voice.close()


@pytest.fixture
def both(base_port: int, keys: Keys, monkeypatch: pytest.MonkeyPatch) -> Iterator[Both]:
    made = Both(base_port, keys, monkeypatch)
    yield made
    made.close()


def test_an_absent_voice_is_silent_and_one_that_comes_later_is_heard(both: Both) -> None:
    until(lambda: both.hears(Heard.SILENT))
    process = both.start()
    until(lambda: both.hears(Heard.LIVE))
    assert both.voice.now.hears
    assert not both.voice.now.recorded
    until(lambda: both.took(3))
    assert [sound.direction for sound in both.taken[:3]] == ["from_remote"] * 3
    assert 0.0 <= both.taken[0].uncertainty_s < 0.5
    process.consents = True
    until(lambda: both.step() or both.voice.now.recorded)


def test_what_the_remote_site_says_of_itself_is_known(both: Both) -> None:
    process = both.start()
    for state, heard in [(VoiceState.MUTED, Heard.MUTED), (VoiceState.ABSENT, Heard.NO_MICROPHONE)]:
        process.state, process.hears = state, False
        until(lambda heard=heard: both.hears(heard))
        until(lambda: both.step() or not both.voice.now.hears)


def test_a_page_is_heard_with_its_time_and_its_state(both: Both) -> None:
    process = both.start()
    both.talk = Talk(VoiceState.MUTED)
    until(lambda: both.step() or (process.end and process.end.far and process.end.far.state is VoiceState.MUTED))
    both.talk = Talk(VoiceState.TALKS, "dr 1", hears=True)
    until(lambda: both.took(1))

    def heard() -> bool:
        captured_s = both.voice._clock_ns() * 1e-9 - 0.05
        assert both.voice.say(VoiceSound("to_remote", 1, captured_s, 0.001, CONTENT))
        both.step()
        return len(process.sounds) >= 3

    until(heard)
    assert both.voice.now.talker == "dr 1"
    assert process.end is not None
    assert process.end.far is not None
    assert (process.end.far.session, process.end.far.hears, process.end.far.consents) == (7, True, True)
    assert all(0.04 < age_s < 0.5 for age_s in process.ages_s)


def test_an_old_sound_of_a_page_is_not_sent(both: Both) -> None:
    both.start()
    until(lambda: both.took(1))
    captured_s = both.voice._clock_ns() * 1e-9 - 0.6
    assert not both.voice.say(VoiceSound("to_remote", 1, captured_s, 0.001, CONTENT))


@pytest.mark.long
def test_a_lost_voice_is_silent_and_its_next_start_is_heard(both: Both) -> None:
    both.start()
    until(lambda: both.took(2))
    both.end()
    until(lambda: both.hears(Heard.SILENT))
    assert not both.voice.now.hears
    count = len(both.taken)
    both.start()
    until(lambda: both.hears(Heard.LIVE))
    until(lambda: both.took(count + 2))


@pytest.mark.long
def test_a_refused_key_is_named_and_heard_once_it_is_trusted(both: Both, keys: Keys) -> None:
    public = load_keys(keys.operator).public
    TrustedKeys(keys.remote).revoke("operator")
    both.start()
    until(lambda: both.hears(Heard.REFUSED))
    TrustedKeys(keys.remote).trust("operator", public)
    until(lambda: both.hears(Heard.LIVE))


def test_a_damaged_packet_is_dropped_and_the_next_sound_is_heard(both: Both) -> None:
    process = both.start()
    until(lambda: both.took(1))
    process.send_raw(b"damaged")
    process.send_raw(b"two", b"parts")
    until(lambda: both.damaged() == 2)
    until(lambda: both.took(2))


@pytest.mark.long
def test_an_oversized_packet_ends_the_connection_only(both: Both) -> None:
    process = both.start()
    until(lambda: both.took(1))
    process.send_raw(bytes(20_000))
    before = process.end
    until(lambda: both.step() or process.end is not before)
    count = len(both.taken)
    until(lambda: both.took(count + 2))


def test_an_old_sound_is_not_relayed(both: Both) -> None:
    process = both.start()
    until(lambda: both.took(1))
    count = len(both.taken)
    process.say(CONTENT, old_s=0.6)
    until(lambda: both.took(count + 1))
    newest_s = both.voice._clock_ns() * 1e-9
    assert all(newest_s - sound.captured_s < 0.5 for sound in both.taken[count:])
