"""All attackers at once beside a one-finger session.

Run as `python -m tests.robustness.adversary.soak --minutes 10 --out DIR`.
"""

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from websockets.exceptions import ConnectionClosed

from teletaction.session.demo_files import CONSOLE
from tests.robustness.adversary.attacked import SITES, Attacked, attacked_session

ATTACKS: tuple[tuple[str, ...], ...] = (
    ("motion", "second"),
    ("hello, then motion", "second"),
    ("motion far ahead", "second"),
    ("small", "second"),
    ("largest", "second", "--deaf"),
    ("looks on", "observer"),
    ("requests", "observer"),
    ("small", "observer", "--deaf"),
    ("largest", "observer"),
    ("requests but a stop", "operator", "--no-motion"),
    ("heartbeats", "operator", "--no-motion"),
    ("largest", "operator", "--no-motion", "--deaf"),
    ("small", "stranger"),
)
"""What, whose key, and options of the attacker. A copy of the operator's key that sends motion, or a stop, would keep
the session from working, as does one at the operator's desk: that is judged elsewhere."""
BETWEEN_STOPS_S = 3.0
ANSWERED_S = 0.300
SHARE = 0.99


def run(out: Path, minutes: float) -> dict[str, Any]:
    """Start a session and its attackers, stop and engage again and again, and judge all of it."""
    wrong: list[str] = []
    with attacked_session(out, console=True) as attacked:
        before = attacked.rss_mib()
        for what, who, *options in ATTACKS:
            attacked.attack(what, who, *options)
        end_s = time.monotonic() + 60.0 * minutes
        while time.monotonic() < end_s and not attacked.session.processes.ended():
            try:
                attacked.wait(BETWEEN_STOPS_S)
                attacked.stop_and_engage()
            except (OSError, AssertionError, ConnectionClosed) as problem:  # a desk, or a page, that does not answer
                wrong.append(repr(problem))
                break
        ended = attacked.session.processes.ended()
        after = attacked.rss_mib() if not ended else {}
        time.sleep(1.5)
        figures = attacked.figures()
        gone = [index for index, attacker in enumerate(attacked.attackers) if attacker.poll() is not None]
    wrong += [f"{name} ended with {code}" for name, code in ended.items()]
    wrong += [f"attacker {index} ended: {ATTACKS[index]}" for index in gone]
    return _judged(attacked, wrong, figures, before, after)


def _judged(
    attacked: Attacked, wrong: list[str], figures: dict[str, Any], before: dict[str, float], after: dict[str, float]
) -> dict[str, Any]:
    latencies_s = np.array([stop.answered_s - stop.asked_s for stop in attacked.stops] or [np.inf])
    in_time = float(np.mean(latencies_s <= ANSWERED_S))
    if in_time < SHARE:
        wrong.append(f"{in_time:.1%} of stops answered within {ANSWERED_S * 1e3:.0f} ms")
    try:
        devices = attacked.judge_devices()
    except AssertionError as error:
        devices = {}
        wrong.append(str(error))
    recorded = attacked.recorded_stops()
    lost = {site: figures[site].get("recording_lost") for site in SITES}
    if any(lost.values()) or any(figures[site].get("recording_failed") for site in SITES):
        wrong.append(f"records were lost: {lost}")
    # The remote site is asked again while it does not confirm, and notes each time.
    if min(recorded.values()) < len(attacked.stops) or {recorded["operator"], recorded[CONSOLE]} != {
        len(attacked.stops)
    }:
        wrong.append(f"of {len(attacked.stops)} stops were recorded: {recorded}")
    return {
        "stops": len(attacked.stops),
        "answered_in_time": in_time,
        "stop_ms": {q: float(np.quantile(latencies_s, float(q)) * 1e3) for q in ("0.5", "0.99", "1")},
        "recorded_stops": recorded,
        "devices": devices,
        "rss_mib": {"before": before, "after": after},
        "loop": {site: figures[site].get("loop") for site in SITES},
        "said": sorted({stop.said[:60] for stop in attacked.stops})[:5],
        "handshakes": figures["remote"].get("handshakes"),
        "wrong": wrong,
    }


def main() -> None:
    """Run, write DIR/attacked.json, print a table; exit code 1 where something was wrong."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--out", type=Path, required=True)
    given = parser.parse_args()
    found = run(given.out, given.minutes)
    (given.out / "attacked.json").write_text(json.dumps(found, indent=1), "utf-8")
    for name, value in found.items():
        print(f"{name:18} {json.dumps(value)}")
    sys.exit(1 if found["wrong"] else 0)


if __name__ == "__main__":
    main()
