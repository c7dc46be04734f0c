"""The shipped scene of a tender patient, end to end: pain, the falling limit, the reports and the place."""

import math
from collections.abc import Iterator
from pathlib import Path

import pytest

from common.limits import CONTACT_FORCE_N, PAIN_LEAST_N
from common.scenes.scene import load_scene
from operator_site.console.model import Console
from operator_site.console.tenderness.tender_search import Tenderness, search_tenderness
from operator_site.session.remote_status import patient_details
from teletaction.session.demo_files import REACTION_S, DemoOptions, prepare
from teletaction.testbed.memory_feed import MemoryFeed
from teletaction.testbed.testbed import Extras, SessionConfigs, Testbed

pytestmark = pytest.mark.long

SCENE = "tender_place"
POLL_S = 0.1
SECONDS = 33.0


class Examined(Testbed):
    """A session of one finger whose console takes the feed, and the answers of the site's local control."""

    def __init__(self, folder: Path) -> None:
        self.feed, self.console = MemoryFeed(), Console()
        files = prepare(DemoOptions(scene=SCENE, fingers=1, seconds=None), folder)
        super().__init__(SessionConfigs.read(files), 0, Extras(feed=self.feed))
        self.limits_n: list[float] = []
        self.beside.append(self._shown)
        self._polled_s = 0.0

    def _shown(self) -> None:
        for fed in self.feed.receive():
            self.console.take(*fed)
        if self.time_s - self._polled_s < POLL_S:
            return
        self._polled_s, client = self.time_s, self.operator.client
        answer = {"session": 1, **patient_details(client.remote_patient, client.patient_ns)}
        self.console.take_answer(self.operator_host.now_ns() * 1e-9, answer)
        self.limits_n.append(self.remote.gate.patient_limit_n or CONTACT_FORCE_N)

    @property
    def found(self) -> Tenderness:
        return search_tenderness(self.console.pain.settled())


@pytest.fixture(scope="module")
def examined(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Examined]:
    session = Examined(tmp_path_factory.mktemp("tender"))
    session.run_coarsely(SECONDS)
    yield session
    session.close()


def test_the_most_tender_place_is_found(examined: Examined) -> None:
    (spot,) = load_scene(SCENE).tender
    found = examined.found
    place = found.known_place
    assert place is not None
    assert math.dist((place.x_m, place.y_m), (spot.x_m, spot.y_m)) < 0.008
    assert found.reports == 2
    assert found.known_reaction_s == pytest.approx(REACTION_S, abs=0.15)


def test_pain_lowers_the_limit_and_no_later_report_raises_it(examined: Examined) -> None:
    limits_n = examined.limits_n
    assert limits_n[0] == CONTACT_FORCE_N
    assert limits_n == sorted(limits_n, reverse=True)
    assert PAIN_LEAST_N <= limits_n[-1] < 3.0


def test_reports_reach_the_console_with_their_places(examined: Examined) -> None:
    patient = examined.console.site.patient
    assert patient is not None
    assert patient.agreed
    assert patient.reports
    assert len(examined.console.pain.reports) == len(patient.reports)
