"""The console's page in a browser on the operator's host.

    screen_end.py ADDRESS SECONDS CAMERA

Prints a line when the page has an engaged session, and a picture where CAMERA is 1. At the end it prints the ages of
what each repaint showed, ms: of touch, and of the picture, null without one.
"""

import json
import sys

from playwright.sync_api import sync_playwright

from tests.browser.conftest import LIVE, chromium

PICTURE = "#camera-said:has-text('Picture 0.')"
LOOK = """async seconds => {
  const names = ["now", "camera", "fingers"];
  const [{ now }, { pictureAge_s }, { age_s }] = await Promise.all(names.map(name => import(`/page/${name}.js`)));
  const found = [], end_ms = performance.now() + 1000 * seconds;
  return new Promise(resolve => {
    const look = () => {
      const delay_ms = now.state?.link.delay_ms, touch_s = age_s(now.active), picture_s = pictureAge_s();
      if (delay_ms && Number.isFinite(touch_s)) found.push([1000 * touch_s + delay_ms, 1000 * picture_s]);
      if (performance.now() < end_ms) requestAnimationFrame(look); else resolve(found);
    };
    requestAnimationFrame(look);
  });
}"""
"""The page counts the age of a touch from its acceptance; the delay of the link before it is the page's mean."""


def main(address: str, seconds: float, camera: bool) -> None:
    """Watch."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium(), args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1024, "height": 768})
        page.set_default_timeout(60_000)
        page.goto(address)
        page.wait_for_selector(LIVE)
        page.wait_for_selector("body[data-shown=engaged]")
        if camera:
            page.wait_for_selector(PICTURE)
        print("shown", flush=True)
        print(json.dumps(page.evaluate(LOOK, seconds)), flush=True)
        browser.close()


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]), sys.argv[3] == "1")
