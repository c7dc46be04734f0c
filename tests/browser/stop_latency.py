"""`python -m tests.browser.stop_latency [PRESSES]`: time from the STOP key to its answer and to the painted page, ms.

The page runs in a real Chromium, against a server in this process that answers as the console does. Times are of the
page's own clock, from the key's event. They hold for a machine that does nothing else.
"""

import statistics
import sys

from playwright.sync_api import sync_playwright

from tests.browser.conftest import LIVE, chromium
from tests.browser.stage import Stage

PRESSES = 60
RECORD = """() => {
  const times = window.times = {};
  const Plain = window.WebSocket;
  window.WebSocket = class extends Plain {
    constructor(...given) {
      super(...given);
      this.addEventListener('message', ({ data }) => {
        if (typeof data === 'string' && data.includes('"kind": "answer"')) times.answered ??= performance.now();
      });
    }
  };
  const pressed = event => { if (event.key === ' ') times.pressed = event.timeStamp; };
  window.addEventListener('keydown', pressed, { capture: true });
  const look = () => {
    if (!times.pressed || times.painted || !['stopping', 'stopped'].includes(document.body.dataset.shown)) return;
    times.painted = Infinity; // until the frame with the change is out
    requestAnimationFrame(() => setTimeout(() => { times.painted = performance.now(); }));
  };
  addEventListener('DOMContentLoaded', () => new MutationObserver(look).observe(document.body, { attributes: true }));
}"""


def main(presses: int = PRESSES) -> None:
    """Press STOP again and again, and print median and largest times."""
    answered, painted = list[float](), list[float]()
    with Stage("engaged") as stage, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium(), args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        page.add_init_script(f"({RECORD})()")
        page.goto(stage.url)
        page.wait_for_selector(LIVE)
        for _ in range(presses):
            stage.show("engaged")
            page.wait_for_selector("body[data-shown=engaged]")
            page.evaluate("() => { for (const name of Object.keys(times)) delete times[name]; }")
            page.keyboard.press("Space")
            page.wait_for_function("() => times.answered && Number.isFinite(times.painted)")
            times = page.evaluate("times")
            page.wait_for_selector("body[data-shown=stopped]")
            answered.append(times["answered"] - times["pressed"])
            painted.append(times["painted"] - times["pressed"])
        browser.close()
    for name, values in (("answered", answered), ("painted", painted)):
        print(f"{name}: median {statistics.median(values):.0f} ms, largest {max(values):.0f} ms, of {presses}")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
