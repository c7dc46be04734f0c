"""The console's process beside a real operator site on a virtual environment, with simulated devices."""

import math
import time
from collections.abc import Iterator
from urllib.error import HTTPError
from urllib.request import Request, urlopen

import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed

from operator_site.console.map.map_tiles import UNEXPLORED
from operator_site.console.state.fingers_now import FIELDS
from robustness.fault_session import read_figures
from tests.commands import command
from tests.system.live_console import Session, running
from tests.system.page import HOSTILE, engage, newest_tiles, opened
from tests.system.truth import written

pytestmark = [pytest.mark.session, pytest.mark.timeout(400)]

FORCE_N = FIELDS.index("force_n")


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Session]:
    with running(tmp_path_factory.mktemp("console")) as session:
        yield session


def test_a_page_from_elsewhere_is_refused(session: Session) -> None:
    with opened(session.address, Origin="https://elsewhere.example") as page, pytest.raises(ConnectionClosed) as closed:
        page.until(lambda: page.state, "nothing")
    assert closed.value.rcvd is not None
    assert closed.value.rcvd.code == 4401
    with pytest.raises(HTTPError, match="401"):
        urlopen(Request(session.address + "/page/main.js", headers={"Host": "elsewhere.example"}))


def test_every_answer_forbids_content_from_elsewhere(session: Session) -> None:
    with urlopen(Request(session.address + "/health")) as response:
        assert response.status == 200
        assert "default-src 'self'" in response.headers["content-security-policy"]
        assert response.headers["x-content-type-options"] == "nosniff"
        assert response.headers["cache-control"] == "no-cache"


def test_a_wrong_message_ends_only_its_own_connection(session: Session) -> None:
    with opened(session.address) as page:
        page.until(lambda: page.state, "a state")
        for text in ("no json", "[" * 20_000):
            with opened(session.address) as other:
                other.connection.send(text)
                with pytest.raises(ConnectionClosed):
                    other.look(5.0)
        page.look(0.2)
        assert page.ask("place", x_mm=1.0, y_mm=1.0)["ok"]


@pytest.mark.protects
def test_an_emergency_stop_is_confirmed_by_each_device_and_seen_at_them(session: Session) -> None:
    with opened(session.address) as page:
        engage(page)
        page.until(lambda: page.picture is not None and np.nanmax(page.picture.fingers[:, FORCE_N]) > 0.05, "a force")
        answer = page.ask("estop")
        assert answer["ok"], answer
        page.until(lambda: (page.state["stop"] or {}).get("confirmed"), "confirmation by all")
        stop = page.state["stop"]
        assert set(stop["devices"]) == {"index", "middle", "exoskeleton"}
        assert all(0.0 < after_s <= 0.3 for after_s in stop["devices"].values())
        stopped_s = time.monotonic()
        page.look(1.0)
        truth = written(session.folder / "sim-operator.mcap", "truth_fingertips", stopped_s, may_be_cut=True)
        assert truth
        assert max(force_n for _, entry in truth for force_n in entry["force_n"]) == 0.0
        assert max(rpm for _, entry in truth for rpm in entry["motor_rpm"]) < 100.0


def test_the_status_file_of_the_console_is_written(session: Session) -> None:
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
        ident = page.ask("finding", finger="index", x_mm=1.0, y_mm=2.0, kind="stiff")["details"]["id"]
        assert page.ask("note", finding=ident, text=HOSTILE)["ok"]
        assert page.ask("disengage")["ok"]
        page.until(lambda: any(f["note"] == HOSTILE and f["saved"] for f in page.state["findings"]), "the finding")
        before, felt = page.state, newest_tiles(page)
        assert felt
        page.look(2.5)  # what the map took in is kept once a second
    session.restart_console()
    with opened(session.address) as page:
        page.until(lambda: page.state and page.state["session"]["state"] == "paused", "the pause")
        assert page.state["session"]["pseudonym"] == before["session"]["pseudonym"]
        assert page.state["findings"] == before["findings"]
        page.until(lambda: felt.keys() <= newest_tiles(page).keys(), "the map")
        shown = newest_tiles(page)
        for place, values in felt.items():
            assert (shown[place][values != UNEXPLORED] != UNEXPLORED).all(), "what was felt is shown again"
        assert page.ask("end")["ok"]
    recordings = (session.folder / "operator.mcap", *sorted(session.folder.glob("console*.mcap")))
    assert len(recordings) == 3
    out = session.folder / "after.html"
    assert command("report", *map(str, recordings), "--out", str(out)).code == 0
    assert out.read_text("utf-8").count('<div class="finding">') == ident
