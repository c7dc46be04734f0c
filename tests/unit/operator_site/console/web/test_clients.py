"""Credit: at most two pictures are under way to a page, whatever it does."""

from hypothesis import given
from hypothesis import strategies as st

from common.web.access import Visitor
from operator_site.console.web.clients import AWAKE_S, CREDIT, SEEN_S, STATE_EVERY_S, Client


def client() -> Client:
    return Client(Visitor("console", "act"), "console 1", 0.0)


@given(st.lists(st.one_of(st.just("picture"), st.integers(0, 3), st.floats(0.0, 5.0)), max_size=100))
def test_no_more_than_its_credit_is_ever_under_way(course: list[object]) -> None:
    page, now_s, sequence = client(), 0.0, 0
    under_way: list[int] = []
    for step in course:
        if step == "picture":
            sequence += 1
            if page.has_credit(now_s, sequence):
                page.sent_picture(sequence, sequence)
                under_way.append(sequence)
        elif isinstance(step, int):
            asleep = not page.awake(now_s)
            page.heard(now_s)
            if asleep:
                under_way.clear()  # it has a socket of its own time again: what was sent is gone
            drawn = under_way[step] if step < len(under_way) else -1
            page.drew(now_s, drawn)
            under_way = [number for number in under_way if number > drawn]
        elif isinstance(step, float):
            now_s += step
        assert len(under_way) <= CREDIT


def test_a_picture_that_may_not_be_sent_is_counted_once() -> None:
    page = client()
    for sequence in range(1, 11):
        if page.has_credit(0.1, sequence):
            page.sent_picture(sequence, sequence)
        page.has_credit(0.1, sequence)
    assert page.skipped == 10 - CREDIT


def test_a_page_that_woke_is_sent_everything_again() -> None:
    page = client()
    page.sent_picture(1, 100)
    page.sent_state(0.0, "x")
    page.tile_revision = 7
    assert not page.wants_state(AWAKE_S + 1.0, "y"), "it sleeps"
    assert not page.has_credit(AWAKE_S + 1.0, 2)
    page.heard(AWAKE_S + 1.0)
    assert page.last_bin is None
    assert page.tile_revision == 0
    assert page.wants_state(AWAKE_S + 1.0, "x")
    assert page.has_credit(AWAKE_S + 1.0, 2)


def test_a_page_is_seen_that_is_visible_and_draws() -> None:
    page = client()
    assert page.seen(1.0)
    for at_s in range(1, 10):
        page.heard(float(at_s))
        page.sent_picture(at_s, at_s)
        page.drew(float(at_s), at_s)
    assert page.seen(9.5)
    page.visible = False
    assert not page.seen(9.5)
    page.visible = True
    page.heard(9.0 + SEEN_S + 0.1)
    assert not page.seen(9.0 + SEEN_S + 0.1), "it says that it is there, and draws nothing"


def test_a_state_is_sent_at_once_when_it_is_urgent_but_no_more_than_ten_times_a_second() -> None:
    page = client()
    sent = []
    for ms in range(1000, 2000, 10):
        page.heard(ms * 1e-3)
        if page.wants_state(ms * 1e-3, ms // 20):
            page.sent_state(ms * 1e-3, ms // 20)
            sent.append(ms)
    assert len(sent) == 10
    quiet = []
    for ms in range(2000, 4000, 10):
        page.heard(ms * 1e-3)
        if page.wants_state(ms * 1e-3, 99):
            page.sent_state(ms * 1e-3, 99)
            quiet.append(ms)
    assert len(quiet) == round(2.0 / STATE_EVERY_S)


def test_a_page_that_asks_without_reading_is_cut_off() -> None:
    page = client()
    assert all(page.answer({}) for _ in range(100))
    assert not page.answer({})


def test_another_choice_of_quantities_is_sent_from_the_beginning() -> None:
    page = client()
    page.tile_revision = 7
    page.show(("temperature",))
    assert page.tile_revision == 7
    page.show(("temperature", "stiffness"))
    assert (page.quantities, page.tile_revision) == (("temperature", "stiffness"), 0)
