"""Every state, in both themes, at both sizes and at 200 % zoom: nothing overflows, nothing is too small, axe finds nothing serious."""

from collections.abc import Callable
from typing import Any

import pytest

from tests.console.conftest import LIVE, SIZES, Open
from tests.console.stage import Stage
from tests.console.synthetic import SCENARIOS

pytestmark = [pytest.mark.console, pytest.mark.timeout(300)]

LOOK = """() => {
  const wrong = [], visible = e => e.checkVisibility({ checkOpacity: false, checkVisibilityCSS: true }) && !e.closest('.unseen, noscript');
  const scrolled = e => { for (let at = e; at; at = at.parentElement) if (['auto', 'scroll'].includes(getComputedStyle(at).overflowY)) return at; return null; };
  const name = e => `${e.tagName.toLowerCase()}#${e.id}.${e.className} "${(e.textContent || '').slice(0, 30)}"`;
  const root = document.documentElement;
  if (root.scrollWidth > innerWidth || root.scrollHeight > innerHeight) wrong.push('the page itself scrolls');
  const words = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (words.nextNode()) {
    const text = words.currentNode, at = text.parentElement;
    if (!text.data.trim() || !visible(at) || ['OPTION', 'SCRIPT'].includes(at.tagName)) continue;
    if (parseFloat(getComputedStyle(at).fontSize) < 16) wrong.push(`under 16 px: ${name(at)}`);
    if (at.closest('.equal')) continue;
    const box = at.closest('button, li, td, th, select, #state, #alarm-line, section, form, header'), outer = box.getBoundingClientRect();
    const range = document.createRange();
    range.selectNodeContents(text);
    for (const part of range.getClientRects()) {
      const scrolls = scrolled(at) !== null && box.contains(scrolled(at));
      const sideways = part.left < outer.left - 2 || part.right > outer.right + 2;
      const updown = part.top < outer.top - 3 || part.bottom > outer.bottom + 3;
      if (sideways || (updown && !scrolls)) { wrong.push(`text leaves its box: ${name(at)} in ${name(box)}`); break; }
    }
  }
  for (const e of document.querySelectorAll('button, select, input, textarea, a')) {
    if (!visible(e)) continue;
    const { width, height } = e.getBoundingClientRect();
    if (width < 59.5 || height < 59.5) wrong.push(`target of ${width.toFixed(0)} x ${height.toFixed(0)}: ${name(e)}`);
  }
  const panels = [...document.querySelectorAll('#bar, #alarm, #hand, #map, #told, #signals, #buttons, #stop-place')].filter(visible);
  for (const a of panels) for (const b of panels) {
    if (a === b || scrolled(a.parentElement) || scrolled(b.parentElement)) continue;
    const p = a.getBoundingClientRect(), q = b.getBoundingClientRect();
    if (p.left < q.right - 1 && q.left < p.right - 1 && p.top < q.bottom - 1 && q.top < p.bottom - 1) wrong.push(`${a.id} over ${b.id}`);
  }
  const stop = document.getElementById('stop');
  if (visible(stop)) {
    const box = stop.getBoundingClientRect();
    if (Math.min(box.width, box.height) < 188) wrong.push('STOP is small');
    if (box.right > innerWidth || box.bottom > innerHeight) wrong.push('STOP is cut');
    for (const [dx, dy] of [[0.5, 0.5], [0.1, 0.5], [0.9, 0.5], [0.5, 0.1], [0.5, 0.9]])
      if (!stop.contains(document.elementFromPoint(box.left + dx * box.width, box.top + dy * box.height))) wrong.push('STOP is covered');
  }
  return [...new Set(wrong)];
}"""


def axe_findings(page: Any) -> list[str]:
    """Serious and critical findings, with where they are."""
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe-playwright-python is not installed")
    found = axe.Axe().run(page, options={"resultTypes": ["violations"]}).response["violations"]
    return [f"{one['id']}: {[node['target'] for node in one['nodes']]}" for one in found if one["impact"] in ("serious", "critical")]


@pytest.mark.parametrize("theme", ["dark", "light"])
@pytest.mark.parametrize("size", SIZES)
def test_every_state_fits_and_is_accessible(stage: Stage, open_page: Open, picture_of: Callable[[Any, str], None], size: str, theme: str) -> None:
    page = open_page("connected", SIZES[size], theme)
    wrong: dict[str, list[str]] = {}
    for name in SCENARIOS:
        if name == "silent":
            stage.show("engaged")
            page.reload()
            page.wait_for_selector("body[data-shown=engaged]")
            stage.show(name)
            page.wait_for_selector("body[data-shown=unknown]")
        else:
            shown = stage.show(name)
            page.reload()
            page.wait_for_selector(LIVE)
            assert page.evaluate("document.body.dataset.role") == shown.state["you"]["role"]
        page.wait_for_timeout(300)  # a round of the numbers, which are written four times a second
        found = page.evaluate(LOOK) + axe_findings(page)
        if found:
            wrong[name] = found
        picture_of(page, f"{name} {size} {theme}")
    assert wrong == {}


SHEETS = {
    "marking": ("engaged", ["f", "2", "ArrowRight"]), "noting": ("engaged", ["n"]), "help": ("engaged", ["?"]), "alarm list": ("fault", ["a"]),
    "details": ("engaged", ["d"]), "roughness": ("engaged", ["r"]), "stiffness": ("engaged", ["s"]), "material": ("engaged", ["m"]), "sure": ("engaged", ["u"]),
}  # fmt: skip


@pytest.mark.parametrize("theme", ["dark", "light"])
@pytest.mark.parametrize("size", SIZES)
def test_what_keys_open_fits_and_is_accessible(stage: Stage, open_page: Open, picture_of: Callable[[Any, str], None], size: str, theme: str) -> None:
    page = open_page("engaged", SIZES[size], theme)
    wrong: dict[str, list[str]] = {}
    for name, (scenario, keys) in SHEETS.items():
        stage.show(scenario)
        page.reload()
        page.wait_for_selector(f"body[data-shown={scenario}]")
        for key in keys:
            page.keyboard.press(key)
        page.wait_for_timeout(300)  # a round of the numbers
        found = page.evaluate(LOOK) + axe_findings(page)
        if found:
            wrong[name] = found
        picture_of(page, f"{name} {size} {theme}")
    assert wrong == {}
