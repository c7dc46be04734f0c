"""Searches the presses of an examination for the most tender place, and says what is known of it."""

from typing import NamedTuple

from common.tenderness.presses import Press
from common.tenderness.tender_place import TenderPlace, tender_place
from operator_site.console.tenderness.pain_presses import Presses

FEWEST_PRESSES = 5
"""Least number of presses of a known place: the search covers little more than the pressed places."""
PLACE_KNOWN_M = 0.012
"""Largest standard deviation of the centre of a known place, m."""
ONE_PLACE = 0.8
"""Least probability that one place is more tender than its surroundings; below it, all may be alike."""
THRESHOLD_KNOWN = 2.5
"""Largest ratio of both ends of the 90 % interval of a known threshold."""
REACTION_KNOWN_S = 0.15
"""Largest standard deviation of a known reaction time, s; it is 0.27 s before the first report."""
CIRCLE_SD = 2.45
"""Radius of the circle that holds the centre with a probability of 95 %, in standard deviations of each direction."""


class Tenderness(NamedTuple):
    """What the presses and answers say.

    Attributes:
        place: the most tender place; None without a report of pain.
        reaction_s, reaction_sd_s: reaction time and its standard deviation, s.
        reports: number of presses with a report of pain.
        presses: presses with a known answer.
    """

    place: TenderPlace | None
    reaction_s: float
    reaction_sd_s: float
    reports: int
    presses: list[Press]

    @property
    def known_place(self) -> TenderPlace | None:
        """The most tender place, where it is known well enough to be shown."""
        known = self.place is not None and self.place.sd_m <= PLACE_KNOWN_M and len(self.presses) >= FEWEST_PRESSES
        return self.place if known else None

    @property
    def place_mm(self) -> tuple[float, float, float] | None:
        """Centre of the known place and its standard deviation in each direction, mm."""
        place = self.known_place
        return None if place is None else (1e3 * place.x_m, 1e3 * place.y_m, 1e3 * place.sd_m)

    @property
    def alike(self) -> bool:
        """Whether all places may be equally tender."""
        return self.place is None or self.place.probability < ONE_PLACE

    @property
    def known_threshold_n(self) -> float | None:
        """The threshold at the most tender place, N; None while it is unknown."""
        place = self.place
        return None if place is None or place.high_n > THRESHOLD_KNOWN * place.low_n else place.threshold_n

    @property
    def known_reaction_s(self) -> float | None:
        """The reaction time, s; None while it is unknown."""
        return self.reaction_s if self.reaction_sd_s <= REACTION_KNOWN_S else None


NOT_SEARCHED = Tenderness(None, 0.0, 1.0, 0, [])


def search_tenderness(given: Presses) -> Tenderness:
    """Search the presses of an examination; this takes up to half a second of processor time."""
    reaction = given.reaction
    reports = sum(press.painful for press in given.presses)
    place = tender_place(given.presses, reaction)
    return Tenderness(place, reaction.mean_s, reaction.sd_s, reports, given.presses)
