"""Assigns the limited places for pages, with separate places for visitors who may act and for observers."""

from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

from common.web.access import Visitor
from operator_site.console.web.clients import Client

ACTING_PLACES = 6
"""Maximum number of pages of visitors who may act; observers never get these places."""
OBSERVING_PLACES = 14
"""Maximum number of pages of visitors who may only observe."""


class Place(NamedTuple):
    """Whether a page gets a place, and the page that leaves for it."""

    given: bool
    leaves: Client | None = None


def place_for(visitor: Visitor, pages: Sequence[Client], holder: Client | None, now_s: float) -> Place:
    """Decide on the place of a new page of this visitor. Pure: `now_s` is on the clock of the pages' heartbeats, s.

    If all places of its role are taken, the page that has slept longest leaves. If none sleeps, the oldest page of the
    visitor with most pages leaves, provided that the new page's visitor then still has fewer. Otherwise the visitor's
    own oldest page leaves. The page in control, the `holder`, always stays.
    """
    same = [page for page in pages if page.visitor.role == visitor.role]
    if len(same) < (ACTING_PLACES if visitor.role == "act" else OBSERVING_PLACES):
        return Place(True)
    others = [page for page in same if page is not holder]
    if asleep := [page for page in others if not page.awake(now_s)]:
        return Place(True, min(asleep, key=lambda page: page.heard_s))
    held = Counter(page.visitor for page in same)
    oldest = max(others, key=lambda page: held[page.visitor])
    if held[oldest.visitor] > held[visitor] + 1:
        return Place(True, oldest)
    own = next((page for page in others if page.visitor == visitor), None)
    return Place(own is not None, own)
