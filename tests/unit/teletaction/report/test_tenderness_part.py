"""Tenderness in the report: only where pain was recorded, with the place, and the same as the console shows."""

import math
from pathlib import Path
from typing import Any

import pytest

from common.recording.recorder import Recorder
from operator_site.console.model import Console
from operator_site.console.tenderness.tender_search import search_tenderness
from teletaction.report.examination import Examination
from teletaction.report.session_report import report
from tests.unit.operator_site.console.tenderness.painful import CENTRE_M, examine
from tests.unit.teletaction.report_page import Page

pytestmark = pytest.mark.usefixtures("coarse")


class Recorded:
    """Records what a console would take; without consent, no answer."""

    live = False

    def __init__(self, recorder: Recorder, consent: bool) -> None:
        self._recorder, self._consent = recorder, consent

    def take(self, stream: str, time_ns: int, payload: bytes) -> None:
        if self._consent or stream != "remote/patient":
            self._recorder.write(stream, time_ns, payload)


def recorded(out: Path, consent: bool) -> Path:
    with Recorder(out, {"operator/touch": {}, "remote/patient": {}}, {"configuration": ""}) as recorder:
        console: Any = Recorded(recorder, consent)
        examine(console)
    return out


@pytest.fixture(scope="module")
def agreed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded(tmp_path_factory.mktemp("agreed") / "session.mcap", consent=True)


@pytest.mark.long
def test_the_report_has_map_place_threshold_reaction_and_number_of_answers(agreed: Path) -> None:
    out = agreed.with_suffix(".html")
    report([agreed], out)
    page = Page(out.read_text("utf-8"))
    found = Examination.read(agreed).tenderness()
    assert found.place_mm is not None
    assert math.dist(found.place_mm[:2], (1e3 * CENTRE_M[0], 1e3 * CENTRE_M[1])) < 4.0
    words = " ".join(page.texts)
    x, y, sd = found.place_mm
    assert f"x {x:.0f}, y {y:.0f} mm, ± {max(1.0, sd):.0f} mm" in words
    assert f"{found.known_threshold_n:.1f} N (90 %: " in words
    assert f"{found.known_reaction_s:.2f} ± {found.reaction_sd_s:.2f} s" in words
    assert f"{found.reports} of 50" in words
    assert 'alt="Map of tenderness"' in out.read_text("utf-8")


@pytest.mark.long
def test_report_and_playback_show_the_same(agreed: Path) -> None:
    console = Console(live=False)
    examine(console)
    assert search_tenderness(console.pain.settled(final=True)) == Examination.read(agreed).tenderness()


@pytest.mark.long
def test_without_consent_the_report_says_nothing_of_pain(tmp_path: Path) -> None:
    path = recorded(tmp_path / "session.mcap", consent=False)
    assert Examination.read(path).tenderness().reports == 0
    out = tmp_path / "report.html"
    report([path], out)
    assert "enderness" not in out.read_text("utf-8")
