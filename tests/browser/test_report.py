"""The report in a real Chromium: no page is wider than the screen, no number is broken, and paper has few pages."""

import math
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import msgpack
import pytest
from mcap.reader import make_reader

from operator_site.console.map.tactile_map import QUANTITIES
from teletaction.privacy.project_files import kind_of
from teletaction.report.examination import Examination
from teletaction.report.examination_page import covered_by
from teletaction.report.session_report import report
from tests.commands import command
from tests.unit.teletaction.recorded_examination import record, record_empty, record_lump

pytestmark = [pytest.mark.console, pytest.mark.timeout(120), pytest.mark.real_time(stall_s=math.inf)]

WIDTHS = (360, 600, 800, 1024, 1440, 1920)
BROKEN = """() => [...document.querySelectorAll('td, dd, th')]
  .filter(cell => cell.offsetParent && !cell.querySelector('.hash, .note'))
  .flatMap(cell => {
    const walker = document.createTreeWalker(cell, NodeFilter.SHOW_TEXT), broken = [];
    for (let node; node = walker.nextNode();)
      for (const word of node.data.matchAll(/\\S+/g)) {
        if (word[0].length > 24) continue;
        const range = document.createRange();
        range.setStart(node, word.index);
        range.setEnd(node, word.index + word[0].length);
        if (new Set([...range.getClientRects()].map(box => Math.round(box.top))).size > 1) broken.push(word[0]);
      }
    return broken;
  })"""
"""Words of cells that stand on more than one line. Hashes, notes, and words of more than 24 letters, may be broken."""


@pytest.fixture(scope="module", params=["examination", "without a console"])
def html(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("report")
    make = record if request.param == "examination" else record_empty
    report([make(folder / "session.mcap")], folder / "report.html")
    return folder / "report.html"


@pytest.mark.parametrize("width", WIDTHS)
def test_nothing_is_wider_than_the_screen_and_no_number_is_broken(browser: Any, html: Path, width: int) -> None:
    context = browser.new_context(viewport={"width": width, "height": 900})
    page = context.new_page()
    page.goto(html.as_uri())
    page.eval_on_selector("details.annex", "annex => annex.open = true")
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert page.evaluate(BROKEN) == []
    context.close()


def test_an_examination_is_printed_on_three_pages_with_the_numbers_of_the_recording(
    browser: Any, tmp_path: Path
) -> None:
    recording = record(tmp_path / "session.mcap", note="a note")
    for name in ("report.html", "report.pdf"):
        assert command("report", recording, "--out", tmp_path / name).code == 0
    assert 2 <= len(re.findall(rb"/Type\s*/Page\b", (tmp_path / "report.pdf").read_bytes())) <= 3
    context = browser.new_context()
    page = context.new_page()
    page.goto((tmp_path / "report.html").as_uri())
    page.emulate_media(media="print")
    signed = page.inner_text("section.signed")
    limits = "The limits of both sites are not in this recording."
    for words in ("P-0417", "35.0 ± 0.2 °C", "a moment, no place", limits, "Signature"):
        assert words in signed, words
    assert not page.is_visible("details.annex")
    context.close()


def test_the_pdf_says_what_the_recording_says_on_three_pages(tmp_path: Path) -> None:
    recording, pdf = record_lump(tmp_path / "session.mcap"), tmp_path / "report.pdf"
    assert command("report", recording, "--out", pdf).code == 0
    assert kind_of(pdf) == "report"
    assert len(messages_of(recording, "console/finding")) == 4
    assert_printed(recording, pdf, "3, and 1 withdrawn")


def assert_printed(recording: Path, pdf: Path, count: str) -> None:
    """The report on paper has three pages with the numbers of the recording; `count` is how it counts the findings."""
    if shutil.which("pdftotext") is None:
        pytest.skip("no pdftotext: install poppler-utils")
    pages = subprocess.run(["pdftotext", "-raw", pdf, "-"], capture_output=True, text=True, check=True).stdout
    signed, *others, end = [" ".join(page.split()) for page in pages.split("\f")]
    assert (len(others), end) == (2, "")
    begun = next(one for one in messages_of(recording, "console/session") if one["what"] == "begin")
    assert begun["pseudonym"] in signed
    if (body := begun["body"]) is not None:
        assert f"{body['side']} {body['region']}, {body['landmark_mm']:g} mm from {body['landmark']}" in signed
    assert count in signed
    for finding in {one["id"]: one for one in messages_of(recording, "console/finding")}.values():
        place = f"{1e3 * finding['x_m']:.0f}, {1e3 * finding['y_m']:.0f}".replace("-", "−")
        assert f"{finding['id']} {finding['kind']} {place} {finding['text']}" in signed
        assert (finding["withdrawn"] or finding["note"] or "–") in signed
        named = f"Finding {finding['id']}: {finding['text']}" in " ".join(others)
        assert named == (not finding["withdrawn"])
        assert finding["compare"] in signed
    examination = Examination.read(recording)
    for quantity in QUANTITIES:
        covered = covered_by(examination, quantity)
        words = "nowhere" if covered is None else f"on {100.0 * covered.felt_m2 / covered.explored_m2:.0f} %"
        assert f"{quantity} {words}" in signed
    assert "Signature" in signed


def messages_of(recording: Path, topic: str) -> list[dict[str, Any]]:
    """Return the content of the messages of one topic, as they were recorded."""
    with recording.open("rb") as file:
        return [msgpack.unpackb(message.data) for _, _, message in make_reader(file).iter_messages(topic)]
