"""The console beside a session: content and rights of its pages, and their effect at the actuators."""

import json
import re
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from common.limits import FORCE_SAFE_S, MOTOR_SAFE_S, MOTOR_STILL_S, THERMAL_SAFE_S
from operator_site.console.examination.examination import LONGEST_NOTE
from operator_site.console.map.map_tiles import UNEXPLORED
from operator_site.console.state.fingers_now import FIELDS
from operator_site.console.state.frame import Kind
from operator_site.console.web.clients import CREDIT
from sim_sensors.network.file import load_network
from teletaction.session.demo_files import WATCHED_S
from teletaction.testbed.memory_feed import MemoryFeed
from teletaction.testbed.network_faults import NetworkFaults
from tests.system.page import HOSTILE, Page, engage, newest_tiles, ready
from tests.system.truth import written
from tests.virtual.conftest import MakeSession
from tests.virtual.console import Consoles
from tests.virtual.session import TICK_S, VirtualSession

pytestmark = pytest.mark.long

FORCE_N, AGE_S = FIELDS.index("force_n"), FIELDS.index("age_s")
IN_USE = {"index", "exoskeleton", "remote hand"}
PICTURES_PER_S = 30
HEARD_S = 2 * TICK_S
"""Time from a page's request until the operator's site has it, s."""
CAUSE_AND_ACT = re.compile(
    r"LINK LOST\. .*Wait for the link\.|Link was lost: .*Acknowledge \(K\)\.|Link slow: \d+ ± \d+ ms\. Move slowly\."
)
"""Texts of the alarms of a network: the cause, then the act."""
EVENING_S, SLOWEST_S = 20.0, 0.15
"""Duration of the network `bad_evening`, and more than its largest delay, s."""
YOUNG_S = 0.020
"""Greatest age of the touch in a picture, s: one comes every 10 ms, and the console looks every 8 ms."""


@pytest.fixture
def feed() -> MemoryFeed:
    return MemoryFeed()


@pytest.fixture
def session(make_session: MakeSession, feed: MemoryFeed) -> VirtualSession:
    return make_session(feed=feed)


@pytest.fixture
def consoles(session: VirtualSession, feed: MemoryFeed, tmp_path: Path) -> Iterator[Consoles]:
    with closing(Consoles(session, feed, tmp_path)) as consoles:
        yield consoles


def work(page: Page, session: VirtualSession) -> None:
    """Engage from this page, and wait until the operator strokes and feels something."""
    engage(page)
    page.until(lambda: session.at_work, "work")


def show_roughness(page: Page) -> None:
    """Show what a stroke feels, and wait until some of it is there."""
    page.tiles.clear()
    page.send(kind="show", quantity="roughness")
    page.until(lambda: any((tile.value != UNEXPLORED).any() for tile in page.tiles), "what was felt")


def without_a_gap(bins: list[int]) -> bool:
    return bins == list(range(bins[0], bins[0] + len(bins)))


def test_a_page_gets_the_whole_state_and_then_every_bin_once(consoles: Consoles) -> None:
    page = consoles.page()
    page.until(lambda: page.pictures[Kind.PICTURE] > 30, "pictures")
    assert page.pictures[Kind.WHOLE] == 1
    assert without_a_gap(page.bins)
    assert page.state["session"]["state"] == "connected"
    names = {"thumb", "index", "middle", "ring", "little", "exoskeleton", "remote hand"}
    assert {device["name"] for device in page.state["devices"]} == names
    json.dumps(page.state, allow_nan=False)


def test_pictures_come_thirty_times_a_second_and_are_young(consoles: Consoles, session: VirtualSession) -> None:
    page = consoles.page()
    work(page, session)
    before, begun_s = page.pictures.total(), session.time_s
    ages_s = []
    while session.time_s < begun_s + 2.0:
        page.turn()
        assert page.picture is not None
        ages_s.append(float(np.nanmax(page.picture.fingers[:, AGE_S])))
    assert page.pictures.total() - before == pytest.approx(2.0 * PICTURES_PER_S, abs=2)
    assert 0.0 < max(ages_s) <= YOUNG_S
    assert page.picture is not None
    assert page.picture.flags.in_use == (False, True, False, False, False)
    assert page.picture.fingers[1, FORCE_N] == pytest.approx(session.now.force_n, abs=0.05)
    show_roughness(page)
    assert {tile.quantity for tile in page.tiles} == {"roughness"}


def test_a_read_only_page_sees_all_and_may_do_nothing(consoles: Consoles, session: VirtualSession) -> None:
    acting, page = consoles.page(), consoles.page("observe")
    work(acting, session)
    page.until(lambda: page.state and page.picture is not None, "a picture")
    assert page.state["you"]["role"] == "observe"
    verbs = ("engage", "disengage", "estop", "clear_fault", "begin", "end", "finding", "note", "take_control")
    for verb in (*verbs, "clutch", "scale"):
        answer = page.ask(verb)
        assert (answer["ok"], answer["text"]) == (False, "OBSERVER. Control is at console 1.")
    assert page.ask("place", x_mm=0.0, y_mm=0.0)["ok"]
    assert session.both_engaged


def test_a_page_opens_the_clutch_changes_the_scale_and_sees_both(consoles: Consoles, session: VirtualSession) -> None:
    page = consoles.page()
    work(page, session)
    assert page.state["coupling"] == {"open": False, "scale": 1, "edges": []}
    answer = page.ask("scale", scale=2)
    assert (answer["ok"], answer["text"].split(":")[0]) == (False, "a finger presses")
    assert page.ask("clutch", open=True)["ok"]
    page.until(lambda: page.state["coupling"]["open"], "the open clutch")
    page.until(lambda: session.now.force_n == 0.0, "a free finger")
    assert page.ask("scale", scale=2)["ok"]
    assert page.ask("clutch", open=False)["ok"]
    page.until(lambda: page.state["coupling"] == {"open": False, "scale": 2, "edges": []}, "the scale")
    assert session.both_engaged


def test_an_emergency_stop_is_confirmed_by_each_device_and_seen_at_them(
    consoles: Consoles, session: VirtualSession
) -> None:
    page = consoles.page()
    work(page, session)
    first, begun_s = len(session.truth), session.time_s
    assert page.ask("estop")["ok"]
    page.until(lambda: (page.state["stop"] or {}).get("confirmed"), "confirmation by all")
    stop = page.state["stop"]
    assert set(stop["devices"]) == IN_USE
    assert all(0.0 < after_s <= 0.3 for after_s in stop["devices"].values())
    assert page.state["session"]["state"] == "stopped"
    page.look(2.0)
    since = [(now.time_s - begun_s - HEARD_S, now) for now in session.truth[first:]]
    assert max(now.force_n for since_s, now in since if since_s > FORCE_SAFE_S + TICK_S) == 0.0
    assert max(now.motor_mv for since_s, now in since if since_s > MOTOR_SAFE_S + TICK_S) == 0
    assert max(now.motor_rpm for since_s, now in since if since_s > MOTOR_STILL_S + TICK_S) < 100.0
    still = [now for since_s, now in since if since_s > THERMAL_SAFE_S + TICK_S]
    assert {(now.peltier, now.heater) for now in still} == {(0.0, 0.0)}
    assert not page.ask("engage")["ok"]
    assert page.ask("clear_fault")["ok"]
    page.until(lambda: page.state["session"]["state"] in ("connected", "paused"), "cleared")
    assert page.state["stop"] is None


def test_one_of_two_pages_acts_and_either_may_stop(consoles: Consoles, session: VirtualSession) -> None:
    first, second = consoles.page(), consoles.page()
    work(first, session)
    second.until(lambda: second.state and second.picture is not None, "a picture")
    assert not second.state["you"]["in_control"]
    answer = second.ask("disengage")
    assert (answer["ok"], answer["text"]) == (False, "Control is at console 1. Take control first.")
    assert "Not while engaged" in second.ask("take_control")["text"]
    assert second.ask("estop")["ok"]
    first.until(lambda: first.state["session"]["state"] == "stopped", "the stop")
    assert session.latched == (True, True)
    assert session.now.force_n == 0.0
    assert first.ask("clear_fault")["ok"]
    assert second.ask("take_control")["ok"]
    first.until(lambda: not first.state["you"]["in_control"], "the other's control")
    assert first.state["you"]["control"] == second.state["you"]["name"]
    second.connection.close()
    first.until(lambda: first.state["you"]["in_control"], "control, for the other page is gone")


def test_a_page_that_does_not_draw_is_not_flooded_and_disturbs_no_other(consoles: Consoles) -> None:
    quick = consoles.page()
    quick.until(lambda: quick.pictures[Kind.PICTURE] > 5, "pictures")
    slow = consoles.page(draws=False)
    slow.look(2.0)
    assert slow.undrawn == CREDIT
    assert slow.state["console"]["pictures_skipped"] > 20
    before = quick.pictures.total()
    quick.look(1.0)
    assert quick.pictures.total() - before >= PICTURES_PER_S - 2, "as without the other"
    assert slow.undrawn == CREDIT
    assert slow.picture is not None
    slow.draws = True
    slow.send(kind="drawn", sequence=slow.picture.sequence)
    slow.until(lambda: slow.pictures.total() > 10, "pictures again")
    assert without_a_gap(slow.bins)


def test_findings_and_notes_are_kept_as_they_were_written(consoles: Consoles) -> None:
    page = consoles.page()
    ready(page)
    page.until(lambda: page.picture, "a picture")
    assert page.picture is not None
    found = page.ask("finding", finger="index", x_mm=12.5, y_mm=-20.0, kind="warm", at_s=page.picture.time_s)
    assert found["ok"], found
    ident = found["details"]["id"]
    assert page.ask("note", finding=ident, text="half \ud83d")["ok"], "half a character is no reason to lose the rest"
    longest = (HOSTILE * LONGEST_NOTE)[:LONGEST_NOTE]
    assert page.ask("note", finding=ident, text=longest)["ok"]
    assert not page.ask("note", finding=ident, text="x" * (LONGEST_NOTE + 1))["ok"]
    assert not page.ask("note", finding=ident + 100, text="x")["ok"]

    def saved() -> bool:
        return any(f["id"] == ident and f["saved"] and f["note"] == longest for f in page.state["findings"])

    page.until(saved, "the newest note on the disk")
    kept = [record for _, record in written(consoles.record, "console/finding", may_be_cut=True)]
    assert [record["note"] for record in kept] == ["", "half \ufffd", longest]
    assert kept[-1]["x_m"] == pytest.approx(0.0125)
    acts = [act for _, act in written(consoles.record, "console/act", may_be_cut=True)]
    assert {"finding", "note"} <= {act["verb"] for act in acts}
    assert {act["who"] for act in acts} == {"console 1"}


def test_a_message_that_is_no_request_is_refused(consoles: Consoles) -> None:
    page = consoles.page()
    page.until(lambda: page.state, "a state")
    for verb, details in (("reboot", {}), ("finding", {"finger": "nose"}), ("begin", {"pseudonym": "Anna Meier"})):
        assert not page.ask(verb, **details)["ok"]
    assert page.state["session"]["pseudonym"] is None
    assert page.ask("place", x_mm=1.0, y_mm=1.0)["ok"]


def test_a_console_that_is_hidden_pauses_the_session(consoles: Consoles, session: VirtualSession) -> None:
    page = consoles.page()
    work(page, session)
    page.look(WATCHED_S + 1.0)
    assert page.state["session"]["state"] == "engaged", "somebody has watched all the time"
    page.visible, hidden_s = False, session.time_s
    page.until(lambda: page.state["session"]["state"] == "paused", "a pause", 8.0)
    # The page says every 0.5 s whether it is visible; the console passes it on every 0.1 s.
    assert WATCHED_S - 0.1 <= session.time_s - hidden_s <= WATCHED_S + 0.8
    assert page.state["session"]["why"] == "Console was hidden for 3 s"
    assert not session.both_engaged


def test_a_new_console_resumes_the_examination_of_an_ended_one(consoles: Consoles, session: VirtualSession) -> None:
    page = consoles.page()
    work(page, session)
    show_roughness(page)
    ident = page.ask("finding", finger="index", x_mm=1.0, y_mm=2.0, kind="stiff")["details"]["id"]
    assert page.ask("note", finding=ident, text=HOSTILE)["ok"]
    assert page.ask("disengage")["ok"]
    page.until(lambda: page.state["session"]["state"] == "paused", "the pause")
    page.until(lambda: any(f["note"] == HOSTILE and f["saved"] for f in page.state["findings"]), "the finding")
    page.look(2.5)  # what the map took in is kept once a second
    before, clock_s, felt = page.state, page.state["session"]["clock_s"], newest_tiles(page)
    consoles.restart()
    page = consoles.page()
    page.send(kind="show", quantity="roughness")
    page.until(lambda: page.state and page.state["session"]["state"] == "paused", "the pause")
    assert page.state["session"]["pseudonym"] == before["session"]["pseudonym"]
    assert page.state["findings"] == before["findings"]
    assert page.state["session"]["clock_s"] > clock_s
    page.until(lambda: any(alarm["id"] == "resumed" for alarm in page.state["alarms"]), "word of the restart")
    page.until(lambda: felt.keys() <= newest_tiles(page).keys(), "the map")
    shown = newest_tiles(page)
    for place, values in felt.items():
        assert (shown[place][values != UNEXPLORED] != UNEXPLORED).all(), "what was felt is shown again"
    assert page.ask("finding", finger="index", kind="warm")["details"]["id"] == ident + 1
    assert f"{ident + 1} findings" in page.ask("end")["text"]


@pytest.mark.parametrize(
    "seconds", [20.0, pytest.param(600.0, marks=[pytest.mark.hardening, pytest.mark.timeout(1800)])]
)
def test_work_over_a_calm_link_raises_no_alarm(consoles: Consoles, session: VirtualSession, seconds: float) -> None:
    page = consoles.page()
    work(page, session)
    raised, until_s = set[str](), session.time_s + seconds
    while session.time_s < until_s:
        page.turn()
        # A disk of this machine may be nearly full, which needs an act.
        raised |= {alarm["text"] for alarm in page.state["alarms"] if alarm["id"] != "disk"}
    assert raised == set()


def test_each_alarm_of_a_bad_evening_names_cause_age_and_act(
    make_session: MakeSession, feed: MemoryFeed, tmp_path: Path
) -> None:
    session = make_session(feed=feed, clocks_agree_s=SLOWEST_S)
    with closing(Consoles(session, feed, tmp_path)) as consoles:
        page = consoles.page()
        work(page, session)
        session.beside.append(NetworkFaults(session.network, load_network("bad_evening")).step)
        raised, begun_s, until_s = set[str](), session.time_s, session.time_s + EVENING_S
        while session.time_s < until_s:
            page.turn()
            for alarm in page.state["alarms"]:
                if alarm["id"] == "disk" or not (alarm["active"] or alarm["waits"]):
                    continue
                raised.add(alarm["text"].split(":")[0].split(".")[0])
                assert CAUSE_AND_ACT.fullmatch(alarm["text"]), alarm
                assert begun_s < alarm["since_s"] <= session.operator_clock.now_ns(session.time_s) * 1e-9
                assert re.fullmatch(r"\d\d:\d\d:\d\d", alarm["since"])
        assert {"LINK LOST", "Link was lost"} <= raised
        assert page.ask("acknowledge")["ok"]
        page.look(1.0)
        standing = [alarm for alarm in page.state["alarms"] if alarm["active"] or alarm["waits"]]
        assert [alarm["text"] for alarm in standing if alarm["id"] != "disk"] == []
