"""Time of jumps in a recording of an hour: until the moment is shown, and until its map and signals are complete.

`python -m benchmarks.consoles.seeking FOLDER` makes the recording, if FOLDER has none, and prints the times as JSON.
The recording has the rates of a session: 500 forces, 100 touches and 20 temperatures a second, with a finger that walks
over the whole map, and a finding and a pause each five minutes.
"""

import json
import math
import sys
import time
from pathlib import Path

import msgpack
import numpy as np

from common.fingers import FINGERS
from common.link.session_state import Happening
from common.recording.recorder import Recorder
from common.wire.messages import NO_TOUCH, ThermalStatus, Touch, pack_rows
from common.wire.packets import LinkState
from common.wire.touch_summary import NOTHING, TouchSummary
from operator_site.console.examination.journal import SCHEMAS as JOURNAL
from operator_site.console.model import Console
from operator_site.console.playback.playback import MOST_CHECKPOINTS, Playback, Recording
from operator_site.console.playback.player import AT_ONCE
from operator_site.site_recording import SCHEMAS

HOUR_S = 3600
JUMPS = 60
_S = 1_000_000_000
_START_NS = 100 * _S
_SUMMARY = TouchSummary((("pvc", 0.91), ("acrylic", 0.05)), 0.12, 0.01, 4e-3, 1e-4)
_EACH_S = 300


def record(path: Path, length_s: int = HOUR_S) -> None:
    """Write the recording."""
    with Recorder(path, SCHEMAS | JOURNAL, {}) as recorder:
        recorder.write("operator/session", _START_NS, Happening("connected", 7, "", None).pack())
        for tick in range(length_s * 500):
            time_ns = _START_NS + tick * _S // 500
            recorder.write("operator/rendered", time_ns, _rendered(tick))
            if tick % 5 == 0:
                recorder.write("operator/touch", time_ns, _touch(tick // 5, time_ns))
            if tick % 25 == 0:
                recorder.write("operator/skin", time_ns, msgpack.packb([[33.0] * 5, [31.0] * 5, [0.0] * 5]))
                recorder.write("operator/clock", time_ns, msgpack.packb([0, 2_000_000, 40_000_000]))
            if tick % 500 == 0:
                recorder.write("operator/figures", time_ns, msgpack.packb({"state": "engaged", "session": 7}))
            if tick % (_EACH_S * 500) == 500:
                recorder.write("operator/session", time_ns, Happening("engaged", 7, "", None).pack())
            if tick % (_EACH_S * 500) == 140_000:
                finding = {"id": 1 + tick // (_EACH_S * 500), "at_s": time_ns * 1e-9, "kind": "warm", "finger": "index"}
                place = {"x_m": 0.0, "y_m": 0.0, "text": "warm, 36.4 ± 0.2 °C", "compare": "", "note": ""}
                recorder.write("console/finding", time_ns, msgpack.packb(finding | place))
                recorder.write("operator/session", time_ns, Happening("disengaged", 7, "", None).pack())
            if tick % 500 == 0:
                while sum(recorder.written.values()) < 1.2 * tick - 10_000:
                    time.sleep(0.001)  # until the writing process has caught up
    if recorder.lost:
        raise OSError(f"the recorder lost {recorder.lost} messages")


def _rendered(tick: int) -> bytes:
    force_n = 1.0 + 0.5 * math.sin(tick / 250)
    five = [[value] * len(FINGERS) for value in (force_n, 6000.0, 30.0, 0.0)]
    rest = [[0] * len(FINGERS), None, 0.01, 0.02, [0.0] * len(FINGERS), [31.0] * len(FINGERS), 1, 0.0]
    return bytes(msgpack.packb([True, 0.004, *five, *rest]))


def _touch(number: int, time_ns: int) -> bytes:
    t_s = number / 100
    finger = {
        "mode": 2.0,
        "contact": float(t_s % 3.0 < 2.5),
        "contact_force_n": 1.5,
        "x_m": 0.1 * math.sin(t_s / 47),
        "y_m": 0.1 * math.sin(t_s / 61),
        "stiffness_n_m": 800.0 * (1.0 + 0.2 * math.sin(t_s / 7)),
        "stiffness_ln_sd": 0.03,
        "object_c": 33.0 + math.sin(t_s / 30),
        "object_c_sd": 0.3,
        "probability": 0.91,
        "thermal_status": float(ThermalStatus.IDENTIFIED),
    }
    rows = [NO_TOUCH._replace(**finger) if at == 1 else NO_TOUCH for at in range(len(FINGERS))]
    summaries = (NOTHING, _SUMMARY, NOTHING, NOTHING, NOTHING)
    names = ("", "pvc", "", "", "")
    return Touch(7, number, time_ns, LinkState.ENGAGED, pack_rows(rows), names, (), summaries).encode()


def measure(path: Path) -> dict[str, object]:
    """Return the times of jumps, s: median and longest."""
    began = time.perf_counter()
    recording = Recording(path)
    playback = Playback(recording, lambda: Console(live=False))
    opened_s = time.perf_counter() - began
    random = np.random.default_rng(32)
    moments_s = random.uniform(0.0, playback.length_s, JUMPS)
    shown_s = []
    for moment_s in moments_s:
        began = time.perf_counter()
        playback.preview(moment_s, 0.0)
        playback.console.picture(playback.now_s, 1, None)
        shown_s.append(time.perf_counter() - began)
    began = time.perf_counter()
    while playback.prepare():
        pass
    ahead_s = time.perf_counter() - began
    complete_s, steps_s = [], []
    for moment_s in moments_s:
        playback.preview(moment_s, 0.0)
        began = time.perf_counter()
        while playback.partial:
            step = time.perf_counter()
            playback.complete(AT_ONCE)
            steps_s.append(time.perf_counter() - step)
        complete_s.append(time.perf_counter() - began)
    recording.close()
    return {
        "length_s": playback.length_s,
        "opened_s": opened_s,
        "shown_s": _spread(shown_s),
        "read_ahead_s": ahead_s,
        "complete_after_s": _spread(complete_s),
        "step_s": _spread(steps_s),
        "checkpoints": MOST_CHECKPOINTS,
        "checkpoints_mib": sum(map(len, playback.checkpoints)) / 2**20,
    }


def _spread(values: list[float]) -> dict[str, float]:
    return {"median": float(np.median(values)), "longest": float(np.max(values))}


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: python -m benchmarks.consoles.seeking FOLDER")
    file = Path(sys.argv[1]) / "hour.mcap"
    file.parent.mkdir(parents=True, exist_ok=True)
    if not file.exists():
        record(file)
    print(json.dumps(measure(file), indent=1))
