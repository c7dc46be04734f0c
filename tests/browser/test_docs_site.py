"""The documentation site in a real Chromium: no page is wider than the window, and lines of text are short."""

import math
from collections.abc import Iterator
from typing import Any

import pytest

from tests.places import ROOT

SITE = ROOT / "site"
PAGES = sorted(SITE.rglob("*.html"))
pytestmark = [
    pytest.mark.console,
    pytest.mark.timeout(600),
    pytest.mark.real_time(stall_s=math.inf),
    pytest.mark.skipif(not PAGES, reason="no site: `make docs` builds it"),
]

WIDTHS = (360, 768, 1024, 1440, 1920)
LONGEST_LINE = 90
"""Largest median length of a line of text in a window of 1440 px, characters."""
LINES = """() => [...document.querySelectorAll('article p')].flatMap(text => {
  const high = parseFloat(getComputedStyle(text).lineHeight), lines = Math.round(text.offsetHeight / high);
  return lines < 3 || text.querySelector('img') ? [] : [text.textContent.length / (lines - 0.5)];
})"""
"""Mean length of a line of each paragraph with three lines or more; the last line counts as half a line."""


@pytest.fixture(scope="module")
def page(browser: Any) -> Iterator[Any]:
    context = browser.new_context()
    yield context.new_page()
    context.close()


def test_no_page_is_wider_than_the_window(page: Any) -> None:
    wide = []
    for path in PAGES:
        page.goto(path.as_uri())
        for width in WIDTHS:
            page.set_viewport_size({"width": width, "height": 900})
            if (needed := page.evaluate("document.documentElement.scrollWidth")) > width:
                wide.append(f"{path.relative_to(SITE)} at {width} px: {needed} px")
    assert wide == []


def test_lines_have_about_eighty_characters(page: Any) -> None:
    page.set_viewport_size({"width": 1440, "height": 900})
    long = []
    for path in (SITE / "docs").glob("how*/*.html"):
        page.goto(path.as_uri())
        lengths = sorted(page.evaluate(LINES))
        if lengths and lengths[len(lengths) // 2] > LONGEST_LINE:
            long.append((path.name, lengths[len(lengths) // 2]))
    assert long == []


def test_the_start_page_shows_its_picture_and_its_links_lead_somewhere(page: Any) -> None:
    page.goto((SITE / "index.html").as_uri())
    assert page.evaluate("document.querySelector('img').naturalWidth") > 1000
    links = page.eval_on_selector_all("a", "links => links.map(link => link.getAttribute('href'))")
    assert len(links) == 4
    assert [link for link in links if not (SITE / link).is_file()] == []
