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


class Told:
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
def told() -> Told:
    return Told()


def test_a_picture_has_its_time_on_this_side_within_the_uncertainty(told: Told) -> None:
    picture = told.picture(1)
    assert picture is not None
    assert abs(picture.captured_s - (told.now_ns - 50 * MS) * 1e-9) <= picture.uncertainty_s
    assert picture.uncertainty_s == pytest.approx(0.015, abs=1e-4)  # half of 40 ms less the camera's 10 ms
    assert told.reader.now(told.now_ns).age_s == pytest.approx(0.05, abs=0.015)


@pytest.mark.parametrize(("apart_ns", "same"), [(9 * MS, True), (-9 * MS, True), (40 * MS, False), (-3 * S, False)])
def test_a_camera_with_the_sites_clock_is_dated_as_touch_is(told: Told, apart_ns: int, same: bool) -> None:
    """The site's offset counts unless it contradicts the camera's: 5 ms of error each way, 15 ms of uncertainty."""
    told.reader.site_clock = AHEAD_NS + apart_ns, 5 * MS
    picture = told.picture(1)
    assert picture is not None
    captured_ns = told.now_ns - 50 * MS
    assert (abs(picture.captured_s - (captured_ns - apart_ns) * 1e-9) < 1e-6) is same
    assert picture.uncertainty_s == pytest.approx(0.005 if same else 0.015, abs=1e-4)


def test_it_asks_first_for_a_key_picture_and_once_a_second_until_it_comes(told: Told) -> None:
    assert told.asked is not None
    assert (told.asked.sequence, told.asked.wants_key) == (0, True)
    reader = PictureReader(0)
    asks = [reader.ask(at * 10 * MS, 0, 0.0, wants_key=False) for at in range(250)]
    made = [ask for ask in asks if ask is not None]
    assert [ask.time_ns for ask in made if ask.wants_key] == [0, round(KEY_S * S), round(2 * KEY_S * S)]
    assert {later.time_ns - ask.time_ns for ask, later in pairwise(made)} == {round(ASK_S * S)}


def test_it_answers_each_picture_at_once_with_the_largest_age_of_touch(told: Told) -> None:
    told.picture(1)
    for touch_age_s in (0.02, 0.09, 0.01):
        told.reader._touch_age_s = max(told.reader._touch_age_s, touch_age_s)
    asked = told.reader.ask(told.now_ns, 7, 0.03, wants_key=False)
    assert asked is not None
    assert (asked.session, asked.sequence, asked.touch_age_us, asked.wants_key) == (7, 1, 90_000, False)
    assert asked.picture_age_us == pytest.approx(50_000, abs=15_000)
    assert told.reader.ask(told.now_ns + MS, 7, 0.0, wants_key=False) is None


def test_a_page_that_waits_gets_a_key_picture_once_a_second(told: Told) -> None:
    told.picture(1)
    asks = [told.reader.ask(told.now_ns + at * 100 * MS, 0, 0.0, wants_key=True) for at in range(1, 31)]
    assert sum(ask is not None and ask.wants_key for ask in asks) == 3


def test_what_follows_a_lost_picture_is_dropped_until_a_key_picture(told: Told) -> None:
    kept = [told.picture(number, is_key=number in {1, 6}) is not None for number in (1, 2, 4, 5, 6, 7)]
    assert kept == [True, True, False, False, True, True]


def test_a_camera_that_was_restarted_is_followed_from_its_first_key_picture(told: Told) -> None:
    assert told.picture(500) is not None
    assert told.picture(1, is_key=False) is None
    assert told.picture(2) is not None


@pytest.mark.parametrize("old_ms", [0, 100, 400])
def test_a_frozen_picture_is_named_half_a_second_after_it_was_captured(told: Told, old_ms: int) -> None:
    told.picture(1, old_ms * MS)
    age_s = told.reader.now(told.now_ns).age_s
    assert told.seen(FROZEN_S - age_s - 0.001) is Seen.LIVE
    assert told.seen(FROZEN_S + 0.001) is Seen.FROZEN
    assert told.seen(SILENT_S + 0.001) is Seen.SILENT
    told.picture(2)
    assert told.seen() is Seen.LIVE


def test_pictures_that_arrive_too_old_are_late(told: Told) -> None:
    told.picture(1, 700 * MS)
    assert told.seen() is Seen.LATE
    assert told.seen(0.6) is Seen.FROZEN


def test_a_camera_that_sends_nothing_is_silent_and_a_refused_key_is_named() -> None:
    reader = PictureReader(0, required=True)
    assert reader.now(400 * MS).seen is Seen.LIVE
    assert reader.now(600 * MS).seen is Seen.FROZEN
    now = reader.now(2 * S)
    assert (now.seen, now.age_s, now.holds) == (Seen.SILENT, 2.0, True)
    assert reader.now(2 * S, refused=True).seen is Seen.REFUSED


def test_a_message_without_a_picture_says_what_the_process_does(told: Told) -> None:
    told.picture(1)
    arguments = {"state": CameraState.NO_CAMERA, "is_key": False}
    assert told.reader.take(message(1, told.now_ns + AHEAD_NS, b"", **arguments), told.now_ns) is None
    assert told.seen() is Seen.NO_CAMERA
    told.picture(2, state=CameraState.GIVES_WAY)
    assert told.reader.now(told.now_ns).reduced


def test_an_oversized_picture_and_an_answer_to_nothing_are_counted_and_dropped(told: Told) -> None:
    whole = message(1, told.now_ns + AHEAD_NS)
    never_asked = message(1, told.now_ns, asked_ns=told.now_ns + S, heard_ns=0)
    for parts in ([whole[0], bytes(MAX_PICTURE + 1)], whole[:1], [*whole, b""], [b"", b""], never_asked):
        assert told.reader.take(parts, told.now_ns) is None
    assert told.reader.damaged == 5


@given(st.lists(st.binary(max_size=80), max_size=4))
def test_no_message_makes_it_raise(parts: list[bytes]) -> None:
    reader = PictureReader(0)
    assert reader.take(parts, 1) is None
    assert reader.damaged == 1
