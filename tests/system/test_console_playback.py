"""`teletaction console --play`: a recording in the same page, with another source."""

from collections.abc import Iterator
from pathlib import Path

import msgpack
import numpy as np
import pytest

from common.faults.fault import Fault, FaultCode
from common.recording.recorder import Recorder
from operator_site.console.examination.journal import SCHEMAS as KEPT
from operator_site.console.state.fingers_now import FIELDS
from operator_site.console.state.frame import Kind
from operator_site.site_recording import SCHEMAS
from tests.system.page import Page, opened
from tests.system.played_console import playing
from tests.unit.operator_site.console.fed import INDEX, S, figures, rendered, touch

pytestmark = [pytest.mark.session, pytest.mark.timeout(120)]

SWINGS = Fault(FaultCode.FORCE_SWINGS, "index", value=1.2, rate_hz=23.0)
SECONDS = 20
START_S = 100
CONTACT_N = FIELDS.index("contact_n")


def record(path: Path) -> None:
    """A session in which the contact force rises by 0.1 N each second; found at 12 s, a fault at 15 s."""
    with Recorder(path, SCHEMAS | KEPT, {}) as recorder:

        def write(stream: str, at_s: float, entry: object) -> None:
            recorder.write(stream, round((START_S + at_s) * S), bytes(msgpack.packb(entry)))

        write("operator/session", 0.0, ["connected", 7, ""])
        begun = {
            "what": "begin",
            "at_s": START_S + 0.0,
            "pseudonym": "P-0417",
            "wall_clock": "2026-11-03T14:07:00+01:00",
        }
        write("console/session", 0.0, begun)
        write("operator/session", 0.001, ["engaged", 7, "", None])
        for n in range(SECONDS * 100):
            at_ns = START_S * S + n * S // 100
            force_n = 0.1 * (n // 100)
            recorder.write("operator/touch", at_ns, touch(n, at_ns - 20_000_000, contact_force_n=force_n))
            recorder.write("operator/rendered", at_ns, rendered())
            if n % 100 == 0:
                fault = {"state": "fault", "fault": SWINGS} if n >= 1500 else {}
                recorder.write("operator/figures", at_ns, figures(**fault))
        place = {"kind": "warm", "finger": "index", "x_m": 0.01, "y_m": 0.0, "text": "warm", "compare": "", "note": "n"}
        write("console/finding", 12.0, {"id": 1, "at_s": START_S + 11.5, **place})
        write("operator/session", 15.0, ["fault", 7, "", SWINGS])


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    path = tmp_path_factory.mktemp("played") / "session.mcap"
    record(path)
    with playing(path) as address:
        yield address


def at(page: Page, at_s: float) -> None:
    """Jump to a moment and wait until it is shown."""
    assert page.ask("seek", at_s=at_s)["ok"]
    whole = page.pictures[Kind.WHOLE]
    page.until(lambda: page.pictures[Kind.WHOLE] > whole or page.pictures[Kind.WHOLE] > 1, "a whole picture")
    page.until(lambda: page.state["session"]["playback"]["at_s"] == pytest.approx(at_s), "the moment")
    page.look(0.3)


def test_a_recording_is_shown_as_it_was(address: str) -> None:
    with opened(address) as page:
        page.until(lambda: page.state and page.picture is not None, "a picture")
        session = page.state["session"]
        assert session["title"] == "3 Nov 2026 14:07"
        assert session["playback"]["length_s"] == pytest.approx(SECONDS, abs=0.1)
        kinds = [(mark["kind"], round(mark["at_s"], 1)) for mark in session["playback"]["marks"]]
        assert kinds == [("mode", 0.0), ("finding", 11.5), ("fault", 15.0), ("mode", 15.0)]
        at(page, 10.0)
        assert page.picture is not None
        assert page.picture.flags.playback
        assert page.picture.fingers[INDEX, CONTACT_N] == pytest.approx(1.0)
        assert page.state["session"]["state"] == "engaged"
        assert page.state["findings"] == []
        assert page.state["session"]["pseudonym"] == "P-0417"
        assert page.whole is not None
        newest = page.whole.bins[-1, INDEX * 5 + 1]
        assert newest == pytest.approx([1.0, 1.0], abs=0.11)
        page.until(lambda: page.tiles, "what was felt")


def test_a_jump_ahead_and_back_is_the_same_as_playing(address: str) -> None:
    with opened(address) as page:
        page.until(lambda: page.state, "a state")
        at(page, 16.0)
        assert page.state["session"]["state"] == "fault"
        assert page.state["alarms"][0]["text"] == "Index: force swings 23 Hz, 1.2 N. Force is off."
        assert [finding["note"] for finding in page.state["findings"]] == ["n"]
        at(page, 5.0)
        assert page.state["session"]["state"] == "engaged"
        assert page.state["alarms"] == []
        assert page.picture is not None
        assert page.whole is not None
        assert page.picture.fingers[INDEX, CONTACT_N] == pytest.approx(0.5)
        assert np.nanmax(page.whole.bins[:, INDEX * 5 + 1]) <= 0.5 + 1e-6, "nothing of a later time is left"


def test_playback_runs_at_its_speed_and_can_pause(address: str) -> None:
    with opened(address) as page:
        page.until(lambda: page.state, "a state")
        at(page, 2.0)
        assert page.ask("play", speed=8.0)["ok"]
        page.until(lambda: page.state["session"]["playback"]["at_s"] > 10.0, "eight seconds", 6.0)
        assert page.ask("pause")["ok"]
        page.look(0.4)
        stands_s = page.state["session"]["playback"]["at_s"]
        page.look(0.5)
        assert page.state["session"]["playback"]["at_s"] == stands_s
        assert not page.state["session"]["playback"]["playing"]


def test_nothing_in_a_recording_acts(address: str) -> None:
    with opened(address) as page:
        page.until(lambda: page.state, "a state")
        for verb in ("engage", "estop", "finding", "note", "end", "clear_fault"):
            assert not page.ask(verb)["ok"]
        assert not page.ask("seek", at_s="there")["ok"]
        assert page.ask("place", x_mm=10.0, y_mm=0.0)["ok"]
