"""The displayed state of a session is never more than the live state."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.link.session_display import (
    ACTING,
    CONNECTED,
    DISCONNECTED,
    ENGAGED,
    ENGAGING,
    FAULT,
    LOST,
    PAUSED,
    SILENT,
    STOPPED,
    Source,
    seconds_old,
    shown_state,
)

KNOWN = st.sampled_from((DISCONNECTED, CONNECTED, ENGAGING, ENGAGED, PAUSED, FAULT, STOPPED))
AGES_S = st.floats(0.0, 1e6) | st.floats(allow_nan=True, allow_infinity=True)
LIMITS_S = st.floats(0.0, 10.0)
JUST_TOO_OLD = LIMITS_S.map(lambda limit_s: Source(math.nextafter(limit_s, math.inf), limit_s))
SOURCES = st.lists(st.builds(Source, AGES_S, LIMITS_S) | JUST_TOO_OLD, max_size=4)


@given(KNOWN, SOURCES, st.booleans(), st.booleans())
def test_acting_states_are_shown_only_while_their_sources_are_live(
    known: str, sources: list[Source], link_silent: bool, stopping: bool
) -> None:
    shown = shown_state(known, sources, link_silent=link_silent, stopping=stopping)
    live = all(0.0 <= source.age_s <= source.limit_s for source in sources)
    if shown in ACTING:
        assert live
        assert not link_silent
        assert not stopping
    assert (shown == SILENT) is not live
    if live and not link_silent and not stopping:
        assert shown == known


@pytest.mark.parametrize(("known", "shown"), [(ENGAGED, LOST), (ENGAGING, LOST), (PAUSED, PAUSED), (FAULT, FAULT)])
def test_a_silent_link_ends_only_acting_states(known: str, shown: str) -> None:
    assert shown_state(known, link_silent=True) == shown


@pytest.mark.parametrize("known", [CONNECTED, ENGAGING, ENGAGED, PAUSED, FAULT, STOPPED])
def test_a_stop_wins_over_every_other_state_that_is_live(known: str) -> None:
    assert shown_state(known, link_silent=True, stopping=True) == STOPPED
    assert shown_state(known, (Source(2.0, 1.0),), stopping=True) == SILENT


def test_ages_are_readable() -> None:
    assert (seconds_old(2.04), seconds_old(math.inf)) == ("2.0 s old", "never heard")
