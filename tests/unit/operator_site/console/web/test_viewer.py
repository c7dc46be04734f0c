"""The flow of pictures to one page: only what it can decode, and no queue before a slow page."""

from hypothesis import given
from hypothesis import strategies as st

from common.web.access import Visitor
from operator_site.console.camera.camera_picture import Picture, follows
from operator_site.console.web.viewer import CREDIT, Viewer


def picture(sequence: int, *, is_key: bool = False) -> Picture:
    return Picture(sequence, 1.0, 0.001, is_key, 160, 96, b"vp8")


def viewer() -> Viewer:
    return Viewer(Visitor("student", "observe"))


def test_a_page_that_came_waits_for_a_key_picture() -> None:
    page = viewer()
    assert page.wants_key
    assert not page.offer(picture(3))
    assert page.offer(picture(4, is_key=True))
    assert page.offer(picture(5))
    assert not page.wants_key
    assert len(page.queue) == 2


def test_a_page_that_draws_nothing_gets_no_more_until_a_key_picture() -> None:
    page = viewer()
    sent = [page.offer(picture(number, is_key=number == 0)) for number in range(2 * CREDIT)]
    assert sent == [True] * CREDIT + [False] * CREDIT
    assert not page.offer(picture(20, is_key=True))
    assert not page.wants_key  # it could not be sent
    page.drew(CREDIT - 1)
    assert page.wants_key
    assert not page.offer(picture(21))
    assert page.offer(picture(22, is_key=True))


def test_a_page_that_lost_a_picture_begins_again() -> None:
    page = viewer()
    page.offer(picture(1, is_key=True))
    page.lost()
    assert page.wants_key
    assert not page.queue
    assert not page.offer(picture(2))


def test_a_jump_counts_as_one_picture_until_its_last_one_is_drawn() -> None:
    page = viewer()
    page.restart([picture(number, is_key=number == 10) for number in range(10, 40)])
    assert len(page.queue) == 30
    assert page.offer(picture(40))
    page.drew(39)
    page.drew(40)
    page.drew("40")
    assert page.offer(picture(41))
    page.restart([])
    assert page.wants_key


@given(st.lists(st.one_of(st.booleans(), st.none()), max_size=60))
def test_every_queued_picture_can_be_decoded_and_few_wait(happens: list[bool | None]) -> None:
    """True and False are a key picture and another one that come; None is a picture that is drawn."""
    page, sent, number = viewer(), list[Picture](), 0
    for what in happens:
        if what is None:
            if sent:
                page.drew(sent[-1].sequence)
            continue
        number += 1
        coming = picture(number, is_key=what)
        if page.offer(coming):
            assert follows(coming, sent[-1].sequence if sent else None)
            sent.append(coming)
        assert len(page._undrawn) <= CREDIT
    assert len(page.queue) == len(sent)
