"""Live sessions with a browser and two busy loops beside them.

Run as `python -m tests.robustness.adversary.live_sessions --out DIR`.
"""

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

from playwright.sync_api import Error, sync_playwright

from robustness.fault_session import read_figures
from tests.browser.conftest import THROTTLING_OFF, chromium
from tests.browser.live import begin, engage, opened
from tests.browser.running_demo import running
from tests.busy import busy

BUSY_LOOPS = 2
LOOK_S = 20.0
BETWEEN_LOOKS_S = 0.05
OPENED_MS = 60_000.0
"""Patience with a browser that shares two processors with all of this."""
TRUE_S = 1.5
"""A page that shows a state was sent data younger than this: it says so after 1 s, and looks four times a second."""
SEEN = "() => [document.body.dataset.shown, now.picture === null ? null : now.picture.time_s]"
NO_STATE = ("unknown", "disconnected")


def live(browser: Any, out: Path, seed: int) -> dict[str, Any]:
    """One session; what its page showed, and what was wrong."""
    wrong: list[str] = []
    looks, oldest_s, engaged_looks, not_engaged = 0, 0.0, 0, ""
    with busy(BUSY_LOOPS), running(out, "--fingers", "1", "--seed", str(seed)) as demo:
        pid = read_figures(out, "console")["pid"]
        page = opened(browser, demo.address, patience_ms=OPENED_MS)
        try:
            begin(page, f"P-{seed:04d}")
            engage(page)
        except (Error, AssertionError) as problem:
            not_engaged = str(problem)[:200]  # the machine is too busy for it: what the page shows must be true
        end_s = time.monotonic() + LOOK_S
        while time.monotonic() < end_s:
            before_s = time.monotonic()
            shown, of_s = page.evaluate(SEEN)
            looks += 1
            engaged_looks += shown == "engaged"
            if of_s is not None and shown not in NO_STATE:
                age_s = before_s - of_s
                oldest_s = max(oldest_s, age_s)
                if age_s > TRUE_S:
                    wrong.append(f"it shows {shown} over data that are {age_s:.2f} s old")
            time.sleep(BETWEEN_LOOKS_S)
        if demo.process.poll() is not None:
            wrong.append(f"the demo ended with {demo.process.returncode}")
        if read_figures(out, "console").get("pid") != pid:
            wrong.append("the console ended and was started again")
        page.close()
        try:
            demo.finish()
        except AssertionError as problem:
            if not (not_engaged and "stopped before the session began" in str(problem)):
                wrong.append(str(problem)[:200])
    return {
        "seed": seed,
        "looks": looks,
        "engaged_looks": engaged_looks,
        "not_engaged": not_engaged,
        "oldest_s": oldest_s,
        "wrong": wrong,
    }


def main() -> None:
    """Live through all sessions, write DIR/live.json, print a line for each; exit code 1 where something was wrong."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0, help="of the first session")
    parser.add_argument("--out", type=Path, required=True)
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    found = []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=chromium(), args=["--no-sandbox"], ignore_default_args=list(THROTTLING_OFF)
        )
        for seed in range(given.seed, given.seed + given.count):
            try:
                found.append(live(browser, given.out / f"session-{seed}", seed))
            except (Error, AssertionError) as problem:
                found.append({"seed": seed, "wrong": [str(problem)[:200]]})
            for window in browser.contexts:
                window.close()  # a page that could not be opened would ask for data again and again
            print(json.dumps(found[-1]), flush=True)
        browser.close()
    (given.out / "live.json").write_text(json.dumps(found, indent=1), "utf-8")
    sys.exit(1 if any(each["wrong"] for each in found) else 0)


if __name__ == "__main__":
    main()
