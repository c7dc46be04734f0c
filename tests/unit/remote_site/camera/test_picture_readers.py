"""Credit and key pictures of several readers, whatever they acknowledge."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.wire.camera_messages import CameraAsk
from remote_site.camera.picture_readers import KEY_EVERY_S, MOST_IN_FLIGHT_S, PictureReaders
from remote_site.stream_server import LEFT_S, MOST_READERS


def ask(sequence: int = 0, wants_key: bool = False) -> CameraAsk:
    return CameraAsk(0, sequence, 1, 0, 0, wants_key)


def ns(seconds: float) -> int:
    return round(seconds * 1e9)


def test_a_new_reader_gets_its_first_picture_as_a_key_picture() -> None:
    readers = PictureReaders()
    assert readers.ready(0.0) == []
    reader = readers.take(b"a", True, ask(), ns(1.0))
    assert reader is not None
    assert readers.key_is_due(1.0, readers.ready(1.0))
    assert readers.sent(1, 1.0, True, readers.ready(1.0)) == [reader]
    assert not readers.key_is_due(1.0 + 2 * KEY_EVERY_S, readers.ready(1.0))


def test_a_reader_that_acknowledges_nothing_gets_no_more_than_a_quarter_of_a_second() -> None:
    readers = PictureReaders()
    readers.take(b"a", True, ask(), 0)
    readers.sent(1, 0.0, True, readers.ready(0.0))
    assert readers.ready(0.9 * MOST_IN_FLIGHT_S)
    assert not readers.ready(1.1 * MOST_IN_FLIGHT_S)
    readers.take(b"a", True, ask(1), ns(0.3))
    assert readers.ready(0.3)


def test_a_long_way_is_no_lack_of_credit() -> None:
    """A satellite acknowledges after 0.6 s. All pictures are sent once that is known."""
    readers, way_s = PictureReaders(), 0.6
    readers.take(b"a", True, ask(), 0)
    sent, got, omitted = [], 0, 0
    for number in range(200):
        now_s = number / 15.0
        for sequence, when_s in sent[got:]:
            if when_s + way_s <= now_s:
                readers.take(b"a", True, ask(sequence), ns(now_s))
                got += 1
        if ready := readers.ready(now_s):
            readers.sent(number + 1, now_s, number == 0, ready)
            sent.append((number + 1, now_s))
        else:
            omitted += number > 30
    assert omitted == 0


def test_a_slow_reader_misses_pictures_and_then_needs_a_key_picture() -> None:
    readers = PictureReaders()
    fast, slow = readers.take(b"fast", True, ask(), 0), readers.take(b"slow", False, ask(), 0)
    assert fast is not None
    assert slow is not None
    readers.sent(1, 0.0, True, readers.ready(0.0))
    readers.take(b"fast", True, ask(1), ns(0.01))
    assert readers.sent(2, 0.4, False, readers.ready(0.4)) == [fast]
    readers.take(b"slow", False, ask(1), ns(0.5))
    assert readers.sent(3, 0.5, False, readers.ready(0.5)) == [fast]
    assert slow.needs_key


def test_the_role_of_the_newest_packet_counts() -> None:
    """The same routing identity may come back with another key, and a key may get another role."""
    readers = PictureReaders()
    for operates in (True, False, True):
        reader = readers.take(b"a", operates, ask(), 0)
        assert reader is not None
        assert reader.operates is operates


def test_readers_leave_and_are_limited() -> None:
    readers = PictureReaders()
    assert all(readers.take(bytes([number]), False, ask(), 0) for number in range(MOST_READERS))
    assert readers.take(b"one more", False, ask(), 0) is None
    readers.drop_absent(LEFT_S + 0.1)
    assert readers.present == []
    assert readers.take(b"one more", True, ask(), ns(3.0)) is not None


def test_observers_take_no_place_of_an_operator() -> None:
    readers = PictureReaders()
    for number in range(MOST_READERS):
        readers.take(bytes([number]), False, ask(), 0)
    for number in range(MOST_READERS):
        assert readers.take(b"operator" + bytes([number]), True, ask(), 0) is not None
        assert len(readers.present) == MOST_READERS
    assert all(reader.operates for reader in readers.present)
    assert readers.take(b"one more", True, ask(), 0) is None


@given(
    st.lists(st.tuples(st.sampled_from([b"a", b"b"]), st.integers(0, 40), st.booleans(), st.booleans()), max_size=60)
)
def test_whatever_readers_say_no_picture_follows_a_gap_without_a_key(
    said: list[tuple[bytes, int, bool, bool]],
) -> None:
    """A picture that is no key picture goes only to readers that got the one before it."""
    readers = PictureReaders()
    got: dict[bytes, int] = {}
    newest = 0
    for number, (who, sequence, wants_key, shows) in enumerate(said):
        now_s = 0.1 * number
        readers.take(who, who == b"a", ask(sequence, wants_key), ns(now_s))
        if shows and (ready := readers.ready(now_s)):
            is_key = readers.key_is_due(now_s, ready)
            for reader in readers.sent(newest + 1, now_s, is_key, ready):
                assert is_key or got[reader.who] == newest
                got[reader.who] = newest + 1
            newest += 1


def test_key_pictures_are_at_most_one_a_second() -> None:
    readers = PictureReaders()
    given = 0
    for number in range(100):
        now_s = 0.05 * number
        readers.take(b"a", True, ask(number, wants_key=True), ns(now_s))
        ready = readers.ready(now_s)
        is_key = readers.key_is_due(now_s, ready)
        given += is_key
        readers.sent(number + 1, now_s, is_key, ready)
    assert given == pytest.approx(5.0 / KEY_EVERY_S, abs=1)
