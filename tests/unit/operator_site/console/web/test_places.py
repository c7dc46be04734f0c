"""Places of pages: observers and sleeping pages keep nobody out who may act."""

from hypothesis import given
from hypothesis import strategies as st

from common.web.access import Visitor
from operator_site.console.web.clients import AWAKE_S, Client
from operator_site.console.web.places import ACTING_PLACES, OBSERVING_PLACES, Place, place_for

OPERATOR, COLLEAGUE, STUDENT = Visitor("OR-2", "act"), Visitor("OR-3", "act"), Visitor("student", "observe")
AWAKE, ASLEEP = 10.0, 10.0 - AWAKE_S - 1.0
NOW_S = 10.0


def pages(*visitors: Visitor, heard_s: float = AWAKE) -> list[Client]:
    return [Client(visitor, f"{visitor.name} {number}", heard_s) for number, visitor in enumerate(visitors)]


def test_observers_leave_all_places_to_those_who_may_act() -> None:
    watching = pages(*[STUDENT] * OBSERVING_PLACES)
    assert place_for(OPERATOR, watching, None, NOW_S) == Place(True)
    assert place_for(Visitor("guest", "observe"), pages(*[OPERATOR] * ACTING_PLACES), None, NOW_S) == Place(True)


def test_the_page_that_slept_longest_leaves() -> None:
    acting = pages(*[OPERATOR] * ACTING_PLACES, heard_s=ASLEEP)
    acting[0].heard_s = acting[3].heard_s = ASLEEP - 1.0
    assert place_for(OPERATOR, acting, acting[0], NOW_S) == Place(True, acting[3]), "the one in control stays"
    assert place_for(COLLEAGUE, acting, None, NOW_S) == Place(True, acting[0]), "of whichever visitor"


def test_a_visitor_with_many_pages_keeps_nobody_out() -> None:
    acting = pages(*[OPERATOR] * ACTING_PLACES)
    assert place_for(COLLEAGUE, acting, acting[0], NOW_S) == Place(True, acting[1])
    assert place_for(OPERATOR, acting, acting[0], NOW_S) == Place(True, acting[1]), "nor himself"


def test_a_place_is_refused_where_all_others_are_awake_and_have_no_more() -> None:
    acting = pages(*(Visitor(f"OR-{number}", "act") for number in range(ACTING_PLACES)))
    assert place_for(Visitor("OR-2", "act"), acting, acting[0], NOW_S) == Place(True, acting[2]), "his own"
    assert place_for(Visitor("OR-9", "act"), acting, acting[0], NOW_S) == Place(False)
    assert place_for(Visitor("OR-0", "act"), acting, acting[0], NOW_S) == Place(False), "his own is in control"


@given(
    st.lists(st.tuples(st.sampled_from([OPERATOR, COLLEAGUE, STUDENT]), st.booleans()), max_size=60),
    st.booleans(),
)
def test_who_may_act_always_gets_in_and_control_is_never_taken(
    came: list[tuple[Visitor, bool]], operator_holds: bool
) -> None:
    present: list[Client] = []
    holder: Client | None = None
    for number, (visitor, awake) in enumerate(came):
        place = place_for(visitor, present, holder, NOW_S)
        assert place.given, "two visitors never need all places of their kind"
        assert place.leaves is None or place.leaves is not holder
        present = [page for page in present if page is not place.leaves]
        present.append(Client(visitor, f"{number}", AWAKE if awake else ASLEEP))
        holder = holder or (present[-1] if visitor.role == "act" and operator_holds else None)
        assert sum(page.acts for page in present) <= ACTING_PLACES
        assert sum(not page.acts for page in present) <= OBSERVING_PLACES
