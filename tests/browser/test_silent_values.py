"""Half a second after the data stop, every value on the page is silent: `--`, empty, or shown with its age."""

import math
import re
from typing import Any

import pytest

from tests.browser.conftest import Open
from tests.browser.stage import Stage

pytestmark = [pytest.mark.console, pytest.mark.real_time(stall_s=math.inf)]

SILENT_MS = 500
"""Age at which a value must show that it is old, ms."""
ROUND_MS = 300
"""A round of the numbers, which are written four times a second, ms."""
AGED = {
    "#identification": "#identification-title",
    "#finger-table": "#finger-table .remarks",
    "#details": "#finger-table .remarks",
}
"""Parts whose values may stay, grey, beside their age; and where the age is."""
FACTS = (
    "kbd", "label", "button:not(#session-button)", "option", "#found-list", "#found-title", "#legend", "#strip-times",
    "#strip-labels",
    "#chart-meaning", "#signals-title", "#key-list", "#pseudonym", "#sheet-body", ".equal",
)  # fmt: skip
"""What shows no present value: keys, records, scales, and tables of what was felt in the last seconds."""
VALUES = """([aged, facts]) => [...document.querySelectorAll('body *')]
  .filter(element => [...element.childNodes].some(node => node.nodeType === Node.TEXT_NODE && /\\d/.test(node.data)))
  .filter(element => !element.closest(['script', 'style', 'svg', '[hidden]', ...facts].join()))
  .map(element => {
    const part = Object.keys(aged).find(each => element.closest(each));
    const place = element.closest('[id]').id, cell = element.matches('td, th') ? ` ${element.cellIndex}` : '';
    const age = part ? [...document.querySelectorAll(aged[part])].map(each => each.textContent).join(' ') : '';
    return [`${place}${cell} ${element.className}`, element.textContent.trim(), age];
  })"""


def values(page: Any) -> list[tuple[str, str, str]]:
    """Place, text, and text of the age beside it, of all elements that show a number."""
    return [tuple(found) for found in page.evaluate(VALUES, [AGED, [*FACTS]])]


@pytest.mark.parametrize("details", [False, True])
@pytest.mark.parametrize("stops", ["console", "connection"])
def test_no_value_looks_live_half_a_second_after_the_data_stop(
    stage: Stage, open_page: Open, stops: str, details: bool
) -> None:
    page = open_page("engaged")
    if details:
        page.keyboard.press("d")
    else:
        page.hover("#map-surface")
        page.wait_for_selector("#read-out:has-text('36.4')")
    page.wait_for_selector("#object:has-text('24.')")
    places = {place.split()[0] for place, _, _ in values(page)}
    shown = {"details-table"} if details else {"read-out"}
    assert {
        "clock",
        "delay",
        "link-more",
        "wall-clock",
        "object",
        "against",
        "decision",
        "finger-table",
        *shown,
    } <= places
    if stops == "console":
        stage.scenario.sends = False
        page.wait_for_selector("body[data-shown=unknown]")
    else:
        stage.cut()
        page.wait_for_selector("body[data-shown=unknown]")
        page.wait_for_timeout(SILENT_MS)  # a cut connection is seen at once, when the values are still young
    page.wait_for_timeout(ROUND_MS)
    assert [value for value in values(page) if not any(map(is_silent_or_aged, value[1:]))] == []


def is_silent_or_aged(text: str) -> bool:
    """Whether a text is silent, or says how old what it shows is."""
    return re.search(r"^--|\d s\b|not live|No connection", text) is not None
