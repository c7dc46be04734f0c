"""The console's server beside a real operator site on a virtual environment, with simulated devices."""

import json
import math
import time
from collections.abc import Iterator
from urllib.error import HTTPError
from urllib.request import Request, urlopen

import numpy as np
import pytest
from numpy.typing import NDArray
from websockets.exceptions import ConnectionClosed

from operator_site.console.clients import CREDIT
from operator_site.console.fingers_now import FIELDS
from operator_site.console.map_tiles import NOT_FELT
from operator_site.console.picture import Kind
from operator_site.console.session_book import LONGEST_NOTE
from studies.fault_session import read_figures
from tests.commands import command
from tests.session.live_console import Session, running
from tests.session.page import Page, opened
from tests.session.truth import written

pytestmark = [pytest.mark.session, pytest.mark.timeout(400)]

HOSTILE = "<script>document.title='x'</script> \u202eevil \x00 \U0001f4a5 & \" ' {{7*7}} \\u0000"
FORCE_N, AGE_S = FIELDS.index("force_n"), FIELDS.index("age_s")


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Session]:
    with running(tmp_path_factory.mktemp("console")) as session:
        yield session


def ready(page: Page) -> None:
    """Wait until all devices are there and nothing is latched, and say that sound was heard."""
    page.until(lambda: page.state, "a state")
    if not page.state["you"]["in_control"]:
        assert page.ask("take_control")["ok"]
    page.until(lambda: page.state["session"]["state"] not in ("disconnected",), "a session")
    if page.state["session"]["state"] in ("stopped", "fault"):
        page.until(lambda: page.state["stop"] is None or page.state["stop"]["confirmed"], "a confirmation")
        assert page.ask("clear_fault")["ok"]
    page.until(lambda: page.state["session"]["state"] in ("connected", "paused", "engaged"), "no fault")
    assert page.ask("sound", answer="heard")["ok"]
    if page.state["session"]["pseudonym"] is None:
        assert page.ask("begin", pseudonym="P-0417")["ok"]
    used = {"index", "middle", "exoskeleton"}
    page.until(lambda: used <= {d["name"] for d in page.state["devices"] if d["ready"]}, "all devices")


def engage(page: Page) -> None:
    ready(page)
    if page.state["session"]["state"] != "engaged":
        page.until(lambda: page.state["engage"]["refusal"] == "", "readiness")
        told = page.ask("engage")
        assert told["ok"], told
    page.until(lambda: page.state["session"]["state"] == "engaged", "engaged")


def newest_tiles(page: Page) -> dict[tuple[str, int, int], NDArray[np.uint16]]:
    return {(tile.quantity, tile.column, tile.row): tile.value for tile in page.tiles}


def test_a_page_is_given_all_that_there_is_and_then_every_bin_once(session: Session) -> None:
    with opened(session.address) as page:
        page.until(lambda: page.pictures[Kind.PICTURE] > 30, "pictures")
        assert page.pictures[Kind.WHOLE] == 1
        assert page.bins == list(range(page.bins[0], page.bins[0] + len(page.bins)))
        assert page.state["session"]["state"] in ("disconnected", "connected", "paused", "stopped")
        assert {d["name"] for d in page.state["devices"]} == {
            "thumb", "index", "middle", "ring", "little", "exoskeleton", "remote hand"
        }  # fmt: skip
        json.dumps(page.state, allow_nan=False)


def test_pictures_come_thirty_times_a_second_and_are_young(session: Session) -> None:
    with opened(session.address) as page:
        engage(page)
        before = page.pictures.total()
        page.look(2.0)
        assert 2.0 * 20 <= page.pictures.total() - before <= 2.0 * 33
        assert page.picture is not None
        assert np.nanmax(page.picture.fingers[:, AGE_S]) < 0.3
        assert not page.picture.flags.in_use[0]
        assert page.picture.flags.in_use[1]
        page.until(lambda: page.picture is not None and page.picture.fingers[1, FORCE_N] > 0.1, "a force")
        page.send(kind="show", quantity="stiffness")
        page.until(lambda: page.tiles, "what was felt")
        assert {tile.quantity for tile in page.tiles} == {"stiffness"}


def test_an_observer_sees_all_and_may_do_nothing(session: Session) -> None:
    with opened(session.address, "/session?role=observe") as page:
        page.until(lambda: page.state and page.picture is not None, "a picture")
        assert page.state["you"]["role"] == "observe"
        for verb in ("engage", "disengage", "estop", "clear_fault", "begin", "end", "finding", "note", "take_control"):
            told = page.ask(verb)
            assert not told["ok"]
            assert told["text"].startswith("OBSERVER. Control is at ")
        assert page.ask("place", x_mm=0.0, y_mm=0.0)["ok"]


def test_a_page_from_elsewhere_is_refused(session: Session) -> None:
    with opened(session.address, Origin="https://elsewhere.example") as page, pytest.raises(ConnectionClosed) as closed:
        page.until(lambda: page.state, "nothing")
    assert closed.value.rcvd is not None
    assert closed.value.rcvd.code == 4401
    with pytest.raises(HTTPError, match="401"):
        urlopen(Request(session.address + "/page/main.js", headers={"Host": "elsewhere.example"}))


def test_every_answer_forbids_what_is_not_of_this_page(session: Session) -> None:
    with urlopen(Request(session.address + "/health")) as response:
        assert response.status == 200
        assert "default-src 'self'" in response.headers["content-security-policy"]
        assert response.headers["x-content-type-options"] == "nosniff"
        assert response.headers["cache-control"] == "no-cache"


@pytest.mark.protects
def test_an_emergency_stop_is_confirmed_by_each_device_and_seen_at_them(session: Session) -> None:
    with opened(session.address) as page:
        engage(page)
        page.until(lambda: page.picture is not None and np.nanmax(page.picture.fingers[:, FORCE_N]) > 0.05, "a force")
        told = page.ask("estop")
        assert told["ok"], told
        page.until(lambda: (page.state["stop"] or {}).get("confirmed"), "confirmation by all")
        stop = page.state["stop"]
        assert set(stop["devices"]) == {"index", "middle", "exoskeleton"}
        assert all(0.0 < after_s <= 0.3 for after_s in stop["devices"].values())
        assert page.state["session"]["state"] == "stopped"
        assert stop["text"].startswith("STOPPED. All 3 devices confirmed in 0.")
        stopped_s = time.monotonic()
        page.look(1.0)
        truth = written(session.folder / "sim-operator.mcap", "truth_fingertips", stopped_s, may_be_cut=True)
        assert truth
        assert max(force_n for _, entry in truth for force_n in entry["force_n"]) == 0.0
        assert max(rpm for _, entry in truth for rpm in entry["motor_rpm"]) < 100.0
        assert not page.ask("engage")["ok"]
        assert page.ask("clear_fault")["ok"]
        page.until(lambda: page.state["session"]["state"] in ("connected", "paused"), "cleared")
        assert page.state["stop"] is None


@pytest.mark.protects
def test_of_two_pages_one_acts_and_either_stops(session: Session) -> None:
    with opened(session.address) as first, opened(session.address) as second:
        engage(first)
        second.until(lambda: second.state and second.picture is not None, "a picture")
        assert not second.state["you"]["in_control"]
        refused = second.ask("disengage")
        assert not refused["ok"]
        assert refused["text"].startswith("Control is at console ")
        assert "Not while engaged" in second.ask("take_control")["text"]
        assert second.ask("estop")["ok"]
        first.until(lambda: first.state["session"]["state"] == "stopped", "the stop")
        assert first.ask("clear_fault")["ok"]
        assert second.ask("take_control")["ok"]
        first.until(lambda: not first.state["you"]["in_control"], "the other's control")
        assert first.state["you"]["control"] == second.state["you"]["name"]


def test_a_page_that_does_not_draw_is_not_flooded_and_the_others_do_not_notice(session: Session) -> None:
    with opened(session.address) as quick:
        quick.until(lambda: quick.pictures[Kind.PICTURE] > 5, "pictures")
        before = quick.pictures.total()
        quick.look(1.0)
        alone = quick.pictures.total() - before
    with opened(session.address) as quick, opened(session.address, draws=False) as slow:
        quick.until(lambda: quick.pictures[Kind.PICTURE] > 5, "pictures")
        slow.look(2.0)
        assert slow.undrawn == CREDIT
        assert slow.state["console"]["pictures_skipped"] > 20
        before = quick.pictures.total()
        quick.look(1.0)
        assert quick.pictures.total() - before >= 0.5 * alone, "as many as without the other, on a busy machine, too"
        assert slow.undrawn == CREDIT
        assert slow.picture is not None
        slow.draws = True
        slow.send(kind="drawn", sequence=slow.picture.sequence)
        slow.until(lambda: slow.pictures.total() > 10, "pictures again")
        assert slow.bins == list(range(slow.bins[0], slow.bins[0] + len(slow.bins))), "no bin is missing after that"


def test_findings_and_notes_are_kept_as_they_were_written(session: Session) -> None:
    with opened(session.address) as page:
        ready(page)
        assert page.picture is not None or page.until(lambda: page.picture, "a picture") is None
        told = page.ask("finding", finger="index", x_mm=12.5, y_mm=-20.0, kind="warm", at_s=page.picture.time_s)  # type: ignore[union-attr]
        assert told["ok"], told
        ident = told["details"]["id"]
        assert page.ask("note", finding=ident, text="half \ud83d")["ok"], (
            "half a character is no reason to lose the rest"
        )
        longest = (HOSTILE * LONGEST_NOTE)[:LONGEST_NOTE]
        assert page.ask("note", finding=ident, text=longest)["ok"]
        assert not page.ask("note", finding=ident, text="x" * (LONGEST_NOTE + 1))["ok"]
        assert not page.ask("note", finding=ident + 100, text="x")["ok"]

        def saved() -> bool:
            return any(f["id"] == ident and f["saved"] and f["note"] == longest for f in page.state["findings"])

        page.until(saved, "the newest note on the disk")
        kept = [record for record in session.kept("console/finding") if record["id"] == ident]
        assert kept[-1]["note"] == longest
        assert kept[-1]["x_m"] == pytest.approx(0.0125)
        acts = session.kept("console/act")
        assert {"finding", "note"} <= {act["verb"] for act in acts}
        assert all(str(act["who"]).startswith("console ") for act in acts)


def test_what_is_no_request_is_refused_and_harms_nobody(session: Session) -> None:
    with opened(session.address) as page:
        page.until(lambda: page.state, "a state")
        for verb, details in (("reboot", {}), ("finding", {"finger": "nose"}), ("begin", {"pseudonym": "Anna Meier"})):
            assert not page.ask(verb, **details)["ok"]
        for said in ("no json", "[]", "{}", '{"kind": 7}', '"kind"', "[" * 20_000):
            with opened(session.address) as other:
                other.connection.send(said)
                if said in ('{"kind": 7}',):
                    continue
                with pytest.raises(ConnectionClosed):
                    other.look(5.0)
        page.look(0.2)
        assert page.ask("place", x_mm=1.0, y_mm=1.0)["ok"]


def test_a_console_that_is_hidden_pauses_the_session(session: Session) -> None:
    with opened(session.address) as page:
        engage(page)
        page.look(4.0)
        assert page.state["session"]["state"] == "engaged", "somebody has watched all the time"
        page.visible = False
        page.until(lambda: page.state["session"]["state"] == "paused", "a pause", 8.0)
        assert page.state["session"]["why"] == "Console was hidden for 3 s"


def test_the_process_says_how_it_is(session: Session) -> None:
    with opened(session.address) as page:
        page.look(1.5)
        status = read_figures(session.folder, "console")
        assert status["clients"] == 1
        assert status["damaged"] == 0
        assert 0.0 <= status["loop"]["cpu"] < math.inf
    assert command("console").code == 2


def test_a_console_that_is_killed_is_gone_on_with_by_the_next(session: Session) -> None:
    with opened(session.address) as page:
        engage(page)
        told = page.ask("finding", finger="index", x_mm=1.0, y_mm=2.0, kind="stiff")
        ident = told["details"]["id"]
        assert page.ask("note", finding=ident, text=HOSTILE)["ok"]
        assert page.ask("disengage")["ok"]
        page.until(lambda: page.state["session"]["state"] == "paused", "the pause")
        page.until(lambda: len(page.state["findings"]) == ident, "the finding")
        before, clock_s = page.state, page.state["session"]["clock_s"]
        felt = newest_tiles(page)
        assert felt
        page.look(2.5)  # what the map took in is kept once a second
    session.restart_console()
    with opened(session.address) as page:
        page.until(lambda: page.state and page.state["session"]["state"] == "paused", "the pause")
        assert page.state["session"]["pseudonym"] == before["session"]["pseudonym"]
        assert page.state["findings"] == before["findings"]
        assert page.state["session"]["clock_s"] > clock_s
        page.until(lambda: any(alarm["id"] == "gone on" for alarm in page.state["alarms"]), "word of the restart")
        page.until(lambda: felt.keys() <= newest_tiles(page).keys(), "the map")
        shown = newest_tiles(page)
        for place, before_values in felt.items():
            assert (shown[place][before_values != NOT_FELT] != NOT_FELT).all(), "what was felt is shown again"
        assert page.ask("finding", finger="index", kind="warm")["details"]["id"] == ident + 1
        assert f"{ident + 1} findings" in page.ask("end")["text"]
    recordings = (session.folder / "operator.mcap", *sorted(session.folder.glob("console*.mcap")))
    assert len(recordings) == 3
    out = session.folder / "after.html"
    assert command("report", *map(str, recordings), "--out", str(out)).code == 0
    assert out.read_text("utf-8").count('<div class="finding">') == ident + 1
