"""Presses and answers that reach the console become the most tender place, live and from a recording."""

import math
import pickle
from typing import Any

import pytest

from common.tenderness.patient_row import Patient
from operator_site.console.examination.contrast import propose
from operator_site.console.examination.tender_finding import is_most_tender, propose_tender, tender_text
from operator_site.console.model import Console
from operator_site.console.tenderness.pain_presses import quiet_places
from operator_site.console.tenderness.tender_search import NOT_SEARCHED, Tenderness, search_tenderness
from operator_site.console.web.page_state import page_state
from tests.unit.operator_site.console.fed import S, touch
from tests.unit.operator_site.console.tenderness.painful import CENTRE_M, REACTION_S, examine, press

pytestmark = pytest.mark.long


def searched(console: Console) -> Tenderness:
    return search_tenderness(console.pain.settled(final=True))


@pytest.fixture(scope="module")
def live() -> Console:
    console = Console()
    examine(console)
    console.tenderness = searched(console)
    return console


@pytest.fixture(scope="module")
def played() -> Console:
    console = Console(live=False)
    examine(console)
    console.tenderness = searched(console)
    return console


@pytest.mark.parametrize("kind", ["live", "played"])
def test_place_threshold_and_reaction_are_found(kind: str, request: pytest.FixtureRequest) -> None:
    console: Console = request.getfixturevalue(kind)
    assert console.damaged == 0
    found = console.tenderness
    place = found.known_place
    assert place is not None
    assert math.dist((place.x_m, place.y_m), CENTRE_M) < 0.004
    assert found.known_threshold_n == pytest.approx(1.8, rel=0.3)
    assert found.known_reaction_s == pytest.approx(REACTION_S, abs=0.1)
    assert found.reports == sum(press.painful for press in found.presses) >= 3
    assert len(found.presses) == 50
    assert len(quiet_places(found.presses)) == 50 - found.reports


def test_a_recording_shows_the_same_as_the_live_session_within_its_deviation(live: Console, played: Console) -> None:
    one, other = live.tenderness.place, played.tenderness.place
    assert one is not None
    assert other is not None
    assert math.dist((one.x_m, one.y_m), (other.x_m, other.y_m)) < min(one.sd_m, other.sd_m)
    assert one.threshold_n == pytest.approx(other.threshold_n, rel=0.1)
    patient = played.site.patient
    assert patient is not None
    assert patient.agreed
    assert len(patient.reports) == played.tenderness.reports


def test_the_page_gets_words_and_a_circle(live: Console) -> None:
    state = page_state(live, 100.0, lambda _: True, "operator.toml")["patient"]
    x_mm, y_mm, radius_mm = state["tender"]["circle"]
    assert math.dist((x_mm, y_mm), (25.0, 13.0)) < 4.0
    assert 1.0 < radius_mm < 25.0
    assert state["tender"]["text"].startswith("Most tender near x ")
    assert "; pain from about " in state["tender"]["text"]
    assert state["tender"]["text"].endswith("; reaction about 0.6 s.")
    assert state["agreed"]


def test_what_is_unknown_is_called_so() -> None:
    console = Console()
    press(console, 100.0, *CENTRE_M, 3.0)
    assert page_state(console, 110.0, lambda _: True, "operator.toml")["patient"]["tender"] is None
    console.tenderness = searched(console)
    assert page_state(console, 110.0, lambda _: True, "operator.toml")["patient"]["tender"] == {
        "text": "Most tender not known yet; pain from not known yet; reaction not known yet.",
        "circle": None,
    }


def test_without_a_slider_no_press_is_kept() -> None:
    console = Console()
    console.take("operator/touch", 100 * S, touch(1, 100 * S, contact_force_n=2.0))
    assert console.pain.settled(final=True).presses == []
    assert searched(console).known_place is None


def test_a_press_whose_answer_is_unknown_does_not_count_as_without_pain() -> None:
    console = Console(live=False)
    console.take("remote/patient", 100 * S, Patient(0.0, None).pack())
    for n in range(50):
        if n == 25:
            console.take("remote/patient", round(100.5 * S), Patient(None, None).pack())
        at_ns = 100 * S + n * S // 50
        console.take("operator/touch", at_ns, touch(n, at_ns, contact_force_n=2.0))
    assert console.pain.settled(final=True).presses == []


def test_an_old_answer_is_unknown_in_a_live_session() -> None:
    console = Console()
    console.take_answer(100.0, {"session": 7, "pain": 0.0, "pain_ns": 100 * S})
    for n in range(200):
        at_ns = 102 * S + n * S // 50
        console.take("operator/touch", at_ns, touch(n, at_ns, contact_force_n=2.0 if n < 100 else 0.0))
    assert console.pain.settled(final=True).presses == []


def test_a_press_without_pain_counts_once_its_report_can_no_longer_arrive() -> None:
    console = Console()
    end_s = press(console, 100.0, 0.0, 0.0, 1.0)
    assert len(console.pain.settled().presses) == 1
    console = Console(live=False)
    console.take("remote/patient", 100 * S, Patient(0.0, None).pack())
    for n in range(60):
        at_ns = 100 * S + n * S // 50
        console.take("operator/touch", at_ns, touch(n, at_ns, contact_force_n=2.0 if n < 50 else 0.0))
    before = console.pain.revision
    assert console.pain.settled().presses == []
    console.take("operator/touch", round(end_s * S) + 10 * S, touch(99, round(end_s * S), contact_force_n=0.0))
    assert console.pain.revision == before + 1
    (kept,) = console.pain.settled().presses
    assert len(kept.time_s) == 2, "only its peak counts"


def test_a_checkpoint_goes_on_as_the_console_it_was_made_of() -> None:
    whole, cut = Console(live=False), Console(live=False)
    for console in (whole, cut):
        press(console, 100.0, *CENTRE_M, 3.0)
    cut = pickle.loads(pickle.dumps(cut))
    for console in (whole, cut):
        press(console, 110.0, 0.0, 0.0, 3.0)
    assert searched(whole) == searched(cut)


def test_another_examination_begins_without_presses(live: Console) -> None:
    console = pickle.loads(pickle.dumps(live))
    console.begin_map()
    assert console.tenderness == NOT_SEARCHED
    assert not console.pain.answered


def test_a_damaged_answer_is_counted() -> None:
    console = Console(live=False)
    for row in (Patient(11.0, None), Patient(math.nan, None), Patient(1.0, -1.0)):
        console.take("remote/patient", 100 * S, row.pack())
    assert console.damaged == 3


def test_the_circle_proposes_a_tender_finding_and_says_how_sure_it_is(live: Console) -> None:
    place = live.tenderness.known_place
    assert place is not None
    surface = live.tactile_map

    def proposed(x_m: float, y_m: float) -> dict[str, Any]:
        places = surface.at(x_m, y_m), surface.around(x_m, y_m)
        return propose_tender(propose(*places, None), live.tenderness, x_m, y_m)

    assert is_most_tender(live.tenderness, *CENTRE_M)
    assert proposed(*CENTRE_M)["kind"] == "tender"
    assert proposed(*CENTRE_M)["kinds"]["tender"]["confidence"] in ("fair", "high")
    assert proposed(0.2, 0.2)["kind"] != "tender"
    text, confidence = tender_text(live.tenderness, 0.2, 0.2)
    assert text.startswith("not the most tender place (most tender near x ")
    assert confidence == "low"
    assert tender_text(NOT_SEARCHED, 0.0, 0.0) == ("most tender not known yet; pain from not known yet", "none")
