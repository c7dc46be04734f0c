"""The reader dates each picture on its own clock, passes on what can be decoded, and names what is not live."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.limits import FROZEN_S
from common.wire.camera_messages import ASK_S, MAX_PICTURE, CameraState
from operator_site.console.camera.camera_now import Seen
from operator_site.console.camera.camera_picture import Picture
from operator_site.console.camera.picture_reader import KEY_S, SILENT_S, PictureReader
from tests.unit.operator_site.console.camera.made_pictures import message

MS = 1_000_000
S = 1_000_000_000
AHEAD_NS = 3_600 * S
"""The camera's clock is an hour ahead."""


class Answered:
    """A reader whose camera answers after a way of 20 ms and back after 10 ms."""

    def __init__(self, **more: bool) -> None:
        self.now_ns, self.reader = 10 * S, PictureReader(10 * S, **more)
        self.asked = self.reader.ask(self.now_ns, 7, 0.0, wants_key=False)

    def picture(self, sequence: int, old_ns: int = 50 * MS, **changed: object) -> Picture | None:
        """A picture that was captured `old_ns` before it arrives."""
        asked = self.reader.ask(self.now_ns, 7, 0.0, wants_key=False) or self.asked
        assert asked is not None
        self.asked = asked
        heard_ns = asked.time_ns + 20 * MS + AHEAD_NS
        self.now_ns = asked.time_ns + 40 * MS
        times = {"sent_ns": heard_ns + 10 * MS, "asked_ns": asked.time_ns, "heard_ns": heard_ns}
        return self.reader.take(message(sequence, self.now_ns + AHEAD_NS - old_ns, **(times | changed)), self.now_ns)

    def seen(self, after_s: float = 0.0) -> Seen:
        return self.reader.now(self.now_ns + round(after_s * S)).seen


@pytest.fixture
def answered() -> Answered:
    return Answered()


def test_a_picture_has_its_time_on_this_side_within_the_uncertainty(answered: Answered) -> None:
    picture = answered.picture(1)
    assert picture is not None
    assert abs(picture.captured_s - (answered.now_ns - 50 * MS) * 1e-9) <= picture.uncertainty_s
    assert picture.uncertainty_s == pytest.approx(0.015, abs=1e-4)  # half of 40 ms less the camera's 10 ms
    assert answered.reader.now(answered.now_ns).age_s == pytest.approx(0.05, abs=0.015)


@pytest.mark.parametrize(("apart_ns", "same"), [(9 * MS, True), (-9 * MS, True), (40 * MS, False), (-3 * S, False)])
def test_a_camera_with_the_sites_clock_is_dated_as_touch_is(answered: Answered, apart_ns: int, same: bool) -> None:
    """The site's offset counts unless it contradicts the camera's: 5 ms of error each way, 15 ms of uncertainty."""
    answered.reader.clock.site = AHEAD_NS + apart_ns, 5 * MS
    picture = answered.picture(1)
    assert picture is not None
    captured_ns = answered.now_ns - 50 * MS
    assert (abs(picture.captured_s - (captured_ns - apart_ns) * 1e-9) < 1e-6) is same
    assert picture.uncertainty_s == pytest.approx(0.005 if same else 0.015, abs=1e-4)


def test_it_asks_first_for_a_key_picture_and_once_a_second_until_it_comes(answered: Answered) -> None:
    assert answered.asked is not None
    assert (answered.asked.sequence, answered.asked.wants_key) == (0, True)
    reader = PictureReader(0)
    asks = [reader.ask(at * 10 * MS, 0, 0.0, wants_key=False) for at in range(250)]
    made = [ask for ask in asks if ask is not None]
    assert [ask.time_ns for ask in made if ask.wants_key] == [0, round(KEY_S * S), round(2 * KEY_S * S)]
    assert {later.time_ns - ask.time_ns for ask, later in pairwise(made)} == {round(ASK_S * S)}


def test_it_answers_each_picture_at_once_with_the_largest_age_of_touch(answered: Answered) -> None:
    for touch_age_s in (0.02, 0.09, 0.01):
        assert answered.reader.ask(answered.now_ns, 7, touch_age_s, wants_key=False) is None, "too soon"
    answered.picture(1)
    asked = answered.reader.ask(answered.now_ns, 7, 0.03, wants_key=False)
    assert asked is not None
    assert (asked.session, asked.sequence, asked.touch_age_us, asked.wants_key) == (7, 1, 90_000, False)
    assert asked.picture_age_us == pytest.approx(50_000, abs=15_000)
    assert answered.reader.ask(answered.now_ns + MS, 7, 0.0, wants_key=False) is None


def test_a_page_that_waits_gets_a_key_picture_once_a_second(answered: Answered) -> None:
    answered.picture(1)
    asks = [answered.reader.ask(answered.now_ns + at * 100 * MS, 0, 0.0, wants_key=True) for at in range(1, 31)]
    assert sum(ask is not None and ask.wants_key for ask in asks) == 3


def test_what_follows_a_lost_picture_is_dropped_until_a_key_picture(answered: Answered) -> None:
    kept = [answered.picture(number, is_key=number in {1, 6}) is not None for number in (1, 2, 4, 5, 6, 7)]
    assert kept == [True, True, False, False, True, True]


def test_a_camera_that_was_restarted_is_followed_from_its_first_key_picture(answered: Answered) -> None:
    assert answered.picture(500) is not None
    assert answered.picture(1, is_key=False) is None
    assert answered.picture(2) is not None


@pytest.mark.parametrize("old_ms", [0, 100, 400])
def test_a_frozen_picture_is_named_half_a_second_after_it_was_captured(answered: Answered, old_ms: int) -> None:
    answered.picture(1, old_ms * MS)
    age_s = answered.reader.now(answered.now_ns).age_s
    assert answered.seen(FROZEN_S - age_s - 0.001) is Seen.LIVE
    assert answered.seen(FROZEN_S + 0.001) is Seen.FROZEN
    assert answered.seen(SILENT_S + 0.001) is Seen.SILENT
    answered.picture(2)
    assert answered.seen() is Seen.LIVE


def test_pictures_that_arrive_too_old_are_late(answered: Answered) -> None:
    answered.picture(1, 700 * MS)
    assert answered.seen() is Seen.LATE
    assert answered.seen(0.6) is Seen.FROZEN


def test_a_picture_of_the_future_is_not_live(answered: Answered) -> None:
    answered.picture(1)
    assert answered.picture(2, old_ns=-3600 * S) is None
    assert answered.reader.damaged == 1
    assert answered.seen(after_s=2 * FROZEN_S) is not Seen.LIVE


def test_a_camera_that_sends_nothing_is_silent_and_a_refused_key_is_named() -> None:
    reader = PictureReader(0, required=True)
    assert reader.now(400 * MS).seen is Seen.LIVE
    assert reader.now(600 * MS).seen is Seen.FROZEN
    now = reader.now(2 * S)
    assert (now.seen, now.age_s, now.holds) == (Seen.SILENT, 2.0, True)
    assert reader.now(2 * S, refused=True).seen is Seen.REFUSED


def test_a_message_without_a_picture_says_what_the_process_does(answered: Answered) -> None:
    answered.picture(1)
    arguments = {"state": CameraState.NO_CAMERA, "is_key": False}
    assert answered.reader.take(message(1, answered.now_ns + AHEAD_NS, b"", **arguments), answered.now_ns) is None
    assert answered.seen() is Seen.NO_CAMERA
    answered.picture(2, state=CameraState.GIVES_WAY)
    assert answered.reader.now(answered.now_ns).reduced


def test_an_oversized_picture_and_an_answer_to_nothing_are_counted_and_dropped(answered: Answered) -> None:
    whole = message(1, answered.now_ns + AHEAD_NS)
    never_asked = message(1, answered.now_ns, asked_ns=answered.now_ns + S, heard_ns=0)
    for parts in ([whole[0], bytes(MAX_PICTURE + 1)], whole[:1], [*whole, b""], [b"", b""], never_asked):
        assert answered.reader.take(parts, answered.now_ns) is None
    assert answered.reader.damaged == 5


@given(st.lists(st.binary(max_size=80), max_size=4))
def test_no_message_makes_it_raise(parts: list[bytes]) -> None:
    reader = PictureReader(0)
    assert reader.take(parts, 1) is None
    assert reader.damaged == 1
