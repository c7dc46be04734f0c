"""Both ends of the voice over a way that the test makes: times, age, repetition, credit and restarts."""

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.limits import VOICE_AGE_S
from common.link.voice_end import FORGET_S, IN_FLIGHT_S, Sound, VoiceEnd
from common.wire.voice_messages import ALIVE_S, VoicePacket, VoiceState

MS = 1_000_000
S = 1_000_000_000
AHEAD_NS = 3_600 * S
"""The far clock is an hour ahead."""
CONTENT = b"opus"


def nothing(packed: bytes) -> bytes:
    return packed


class Ends:
    """Two ends; a packet takes 20 ms there and 10 ms back."""

    def __init__(self, there_ns: int = 20 * MS, back_ns: int = 10 * MS) -> None:
        self.now_ns = 10 * S
        self.there_ns, self.back_ns = there_ns, back_ns
        self.near, self.far = VoiceEnd(self.now_ns), VoiceEnd(self.now_ns + AHEAD_NS)

    def pack(self, end: VoiceEnd, sound: tuple[int, bytes] | None = None) -> bytes | None:
        ahead_ns = AHEAD_NS if end is self.far else 0
        return end.pack(self.now_ns + ahead_ns, VoiceState.TALKS, sound, hears=True, consents=False)

    def exchange(self) -> None:
        """One round trip without a sound."""
        self.now_ns += round(ALIVE_S * S)
        asked = self.pack(self.near)
        self.now_ns += self.there_ns
        assert asked is not None
        assert self.far.take(asked, self.now_ns + AHEAD_NS) is None
        answered = self.pack(self.far)
        if answered is not None:
            self.now_ns += self.back_ns
            self.near.take(answered, self.now_ns)

    def say(self, old_ns: int = 20 * MS, change: Callable[[bytes], bytes] = nothing) -> Sound | None:
        """The far end says a sound that began `old_ns` ago; what arrives of it."""
        packed = self.pack(self.far, (self.now_ns + AHEAD_NS - old_ns, CONTENT))
        assert packed is not None
        self.now_ns += self.back_ns
        return self.near.take(change(packed), self.now_ns)


@pytest.fixture
def ends() -> Ends:
    made = Ends()
    for _ in range(3):
        made.exchange()
    return made


@given(st.integers(0, 200 * MS), st.integers(0, 200 * MS), st.integers(0, 150 * MS))
def test_a_sound_has_its_time_on_this_side_within_the_uncertainty(there_ns: int, back_ns: int, old_ns: int) -> None:
    made = Ends(there_ns, back_ns)
    for _ in range(3):
        made.exchange()
    began_ns = made.now_ns - old_ns
    sound = made.say(old_ns)
    assert sound is not None
    assert abs(sound.captured_ns - began_ns) <= sound.uncertainty_ns
    assert (sound.sequence, sound.content) == (1, CONTENT)


def test_a_sound_has_no_time_before_the_clocks_were_compared() -> None:
    made = Ends()
    assert made.say() is None
    assert made.near.counts["damaged"] == 0


def test_an_old_sound_is_neither_sent_nor_taken(ends: Ends) -> None:
    old_ns = round(VOICE_AGE_S * S) + 1
    packed = ends.pack(ends.far, (ends.now_ns + AHEAD_NS - old_ns, CONTENT))
    assert packed is None or not VoicePacket.decode(packed).sound
    assert ends.far.counts["held"] == 1
    ends.back_ns = 490 * MS
    assert ends.say(old_ns=40 * MS) is None
    assert ends.near.counts["old"] == 1


def test_a_repeated_sound_is_taken_once_and_the_next_one_too(ends: Ends) -> None:
    kept: list[bytes] = []

    def keep(packed: bytes) -> bytes:
        kept.append(packed)
        return packed

    assert ends.say(change=keep) is not None
    assert ends.near.take(kept[0], ends.now_ns) is None
    assert ends.say() is not None


@pytest.mark.parametrize("damage", [b"", b"\xff" * 60, b"\x9a"])
def test_a_damaged_packet_is_counted_and_the_next_one_is_taken(ends: Ends, damage: bytes) -> None:
    assert ends.say(change=lambda packed: damage) is None
    assert ends.near.counts["damaged"] == 1
    assert ends.say() is not None


def test_an_answer_to_the_hosts_run_before_compares_no_clocks_and_opens_no_credit(ends: Ends) -> None:
    before = ends.near.clock.own.uncertainty_ns
    far_ns = ends.now_ns + AHEAD_NS
    later_ns = ends.now_ns + S
    packed = VoicePacket(0, 1, far_ns, far_ns, later_ns, far_ns, VoiceState.MUTED, True, False, b"").encode()
    assert ends.near.take(packed, ends.now_ns) is None
    assert ends.near.far is not None
    assert (ends.near.far.state, ends.near.counts["damaged"]) == (VoiceState.MUTED, 0)
    assert ends.near.clock.own.uncertainty_ns == before
    ends.now_ns += 500 * MS
    ends.near.pack(ends.now_ns, VoiceState.TALKS, (ends.now_ns, CONTENT), hears=True, consents=False)
    assert ends.near.counts["held"] == 1


def test_without_acknowledgements_no_sound_is_sent_and_with_one_again(ends: Ends) -> None:
    sent_until_ns = ends.now_ns
    while ends.far.counts["held"] == 0:
        ends.now_ns += 20 * MS
        sent_until_ns = ends.now_ns
        ends.pack(ends.far, (ends.now_ns + AHEAD_NS - 20 * MS, CONTENT))
        assert ends.now_ns < 20 * S
    waited_s = (sent_until_ns - ends.far.heard_ns + AHEAD_NS) * 1e-9
    assert waited_s <= IN_FLIGHT_S + ALIVE_S + 0.1
    for _ in range(2):  # the first one asks for an answer, the second one acknowledges it
        ends.exchange()
    held = ends.far.counts["held"]
    assert ends.say() is not None
    assert ends.far.counts["held"] == held


def test_a_silent_end_says_that_it_is_there_ten_times_a_second() -> None:
    end = VoiceEnd(0)
    sent = [
        at for at in range(100) if end.pack(S + at * 10 * MS, VoiceState.MUTED, hears=False, consents=False) is not None
    ]
    assert sent == list(range(0, 100, 10))


def test_an_end_that_starts_again_with_an_earlier_clock_is_heard(ends: Ends) -> None:
    assert ends.say() is not None
    ends.now_ns += round((FORGET_S + 0.1) * S)
    ends.far = VoiceEnd(ends.now_ns + AHEAD_NS)
    for _ in range(2):
        ends.exchange()
    assert ends.say() is not None
