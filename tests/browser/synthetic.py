"""Pictures, tiles and states as the console would send them, made up for a page under test."""

import math
from copy import deepcopy
from typing import Any

import numpy as np

from common.fingers import FINGERS
from common.wire.packets import LinkState
from operator_site.console.map.map_tiles import HIGHEST, RANGES, STEEP, UNEXPLORED, WORST, MapTile
from operator_site.console.map.tactile_map import LOGARITHMIC, QUANTITIES
from operator_site.console.state.frame import Flags, Frame, Kind, Priority
from operator_site.console.state.signals import SPAN_S
from operator_site.console.state.site_now import DEVICES

DRAWN = {
    "connected": LinkState.CONNECTED, "engaging": LinkState.CONNECTED, "paused": LinkState.CONNECTED,
    "engaged": LinkState.ENGAGED, "fault": LinkState.FAULT, "stopped": LinkState.FAULT,
}  # fmt: skip
"""Link state in a picture for each session state; disconnected for all others."""
MATERIALS = ["skin dermis", "PVC", "rubber", "aluminium", "fat", "acrylic"]


def finger_row(finger: int, time_s: float, scenario: "Scenario") -> list[float]:
    """What one finger's twelve numbers are at a time."""
    nan = math.nan
    if finger in scenario.absent:
        return [nan] * 12
    touching = finger in scenario.touching
    force_n = 2.1 + 0.8 * math.sin(2.0 * time_s + finger) if touching else 0.0
    motor_hz = 62.0 + 8.0 * math.sin(5.0 * time_s) if touching and finger == 1 else 0.0
    plate_c = 31.4 + 0.4 * math.sin(0.5 * time_s + finger)
    x_m = 0.04 * math.sin(0.4 * time_s)
    y_m = -0.04 + 0.02 * finger
    mode = (3 if finger == 1 else 2) if touching else 0
    age_s = scenario.age_s if finger in scenario.stale else 0.01
    return [x_m, y_m, 0.0, force_n, 0.9 * force_n, motor_hz, plate_c, plate_c - 0.6, 32.0, mode, 410.0, age_s]


def bin_values(time_s: float, scenario: "Scenario") -> list[float]:
    """Smallest and largest of the 25 signals in the bin that ends at a time."""
    values: list[float] = []
    for finger in range(5):
        row = finger_row(finger, time_s, scenario)
        for value, spread in ((row[3], 0.15), (row[4], 0.1), (row[5], 3.0), (row[6], 0.05), (row[7], 0.05)):
            values += [value - spread, value + spread] if value else [0.0, 0.0]
    return values


def picture(number: int, bin_number: int, scenario: "Scenario", kind: Kind = Kind.PICTURE, bins: int = 1) -> bytes:
    """A picture with its newest bins."""
    time_s, session = bin_number * SPAN_S, scenario.state["session"]
    priorities = [Priority[alarm["priority"].upper()] for alarm in scenario.state["alarms"]]
    flags = Flags(
        DRAWN.get(session["state"], LinkState.DISCONNECTED),
        max(priorities, default=Priority.NONE),
        session["recording"],
        session["playback"] is not None,
        *(tuple(finger in group for finger in range(5)) for group in (scenario.touching, scenario.limited)),
        tuple(finger not in scenario.absent for finger in range(5)),
    )
    rows = np.array([finger_row(finger, time_s, scenario) for finger in range(5)])
    values = np.array([bin_values(time_s - back * SPAN_S, scenario) for back in range(bins - 1, -1, -1)])
    return Frame(number, time_s, flags, rows, values.reshape(bins, -1, 2), 7, kind).encode()


def _measured(quantity: str, x_mm: float, y_mm: float) -> tuple[float, int] | None:
    """Value and spread of a cell: five lines of a sweep over a warm, rough and stiff place; None where unexplored."""
    lane = min(range(5), key=lambda finger: abs(y_mm - 20.0 * (finger - 2)))
    off_mm = abs(y_mm - 20.0 * (lane - 2))
    if not -70 < x_mm < 95 or off_mm > 8:
        return None
    spread = round(44 + 4 * off_mm) + (STEEP if x_mm < -62 else 0)
    warm = math.exp(-((x_mm - 40) ** 2 + (y_mm + 20) ** 2) / 500)
    stiff = math.exp(-((x_mm + 30) ** 2 + (y_mm - 20) ** 2) / 400)
    rough = math.exp(-(x_mm**2 + y_mm**2) / 600)
    if quantity == "temperature":
        return 33.0 + 3.0 * warm, spread
    if quantity == "roughness":
        return 0.03 * 20**rough, spread
    if quantity == "stiffness":
        return 400.0 * 10**stiff, spread
    return (3 if stiff > 0.5 else 1 if rough > 0.5 else 0), round(8 * off_mm)


def tile(quantity: int, column: int, row: int, revision: int) -> bytes:
    """One tile of the map."""
    name = QUANTITIES[quantity]
    value, spread = np.full((32, 32), UNEXPLORED), np.full((32, 32), WORST)
    for y in range(32):
        for x in range(32):
            found = _measured(name, column * 32 + x - 127.5, row * 32 + y - 127.5)
            if found is not None:
                value[y, x], spread[y, x] = _code(name, found[0]), found[1]
    return MapTile(name, column, row, revision, value, spread).encode()


def _code(quantity: str, value: float) -> int:
    """The value of a cell in a tile."""
    if quantity == "material":
        return int(value)
    scaled, low, high = (math.log(end) if quantity in LOGARITHMIC else end for end in (value, *RANGES[quantity]))
    return round(HIGHEST * (scaled - low) / (high - low))


def finger_state(name: str, **changed: Any) -> dict[str, Any]:
    """The state of one finger."""
    usual: dict[str, Any] = {
        "name": name, "in_use": True, "contact_s": None, "decision": "NO CONTACT",
        "line": "",
        "candidates": [], "object_c": None, "object_c_sd": None, "stiffness_n_m": None, "stiffness_sd_n_m": None,
        "stiffness_known": False, "roughness_v": None, "roughness_sd_v": None, "groove_mm": None, "groove_sd_mm": None,
        "limits": [], "age_s": 0.01, "object_c_uncertain": False, "held_s": None, "against": {},
    }  # fmt: skip
    return usual | changed


IDENTIFIED = {
    "contact_s": 2.4, "decision": "IDENTIFIED", "line": "PVC 91 %",
    "candidates": [["PVC", 0.91], ["acrylic", 0.05], ["rubber", 0.03]], "object_c": 24.1, "object_c_sd": 0.3,
    "stiffness_n_m": 412.0, "stiffness_sd_n_m": 38.0, "stiffness_known": True, "roughness_v": 0.231,
    "roughness_sd_v": 0.018, "groove_mm": 1.02, "groove_sd_mm": 0.04,
    "against": {"temperature": "−0.9 ± 0.3 K", "stiffness": "1.8 ± 0.1 times"},
}  # fmt: skip

BASE: dict[str, Any] = {
    "kind": "state", "version": 1, "wall_clock": "14:07:03",
    "you": {"role": "act", "name": "console", "in_control": True, "control": "console"},
    "session": {"state": "connected", "clock_s": 0.0, "pseudonym": None, "recording": False, "saved": None,
                "playback": None, "title": None, "sound": None, "consented": []},
    "link": {"delay_ms": 23.4, "delay_sd_ms": 2.1, "age_ms": 4.2, "loss": 0.01},
    "alarms": [],
    "fingers": [finger_state(name) for name in FINGERS],
    "devices": [{"name": name, "ready": True, "text": "", "help": ""} for name in DEVICES],
    "checks": [{"name": "Calibration", "ready": True, "text": "3 Nov 2026", "help": ""},
               {"name": "Link", "ready": True, "text": "23 ± 2 ms", "help": ""},
               {"name": "Disk", "ready": True, "text": "212 GB free", "help": ""}],
    "stop": None, "engage": {"wanted": False, "refusal": ""},
    "coupling": {"open": False, "scale": 1, "edges": []},
    "patient": None,
    "map": {"frame": {"x_m": -0.128, "y_m": -0.128, "cell_m": 0.001, "columns": 256, "rows": 256},
            "ranges": {name: list(ends) for name, ends in RANGES.items()},
            "legend": {"temperature": [30.0, 36.0], "roughness": [0.01, 1.0], "stiffness": [100.0, 10000.0],
                       "material": [0, 5]},
            "materials": MATERIALS, "sides": {"top": "head", "right": "left"},
            "lumps": [], "next_mm": None, "moved": None, "stale_mm": [], "roughness_um": None,
            "felt_mm": [-70.0, -48.0, 95.0, 48.0],
            "felt_cells": {"temperature": 12_000, "roughness": 12_000, "stiffness": 12_000, "material": 12_000}},
    "camera": None, "voice": None,
    "findings": [], "undo": None, "changes": 0,
    "meaning": "Calibrated 2026-11-03 (sensor TX-0007), 480 touches, effusivity ± 3 %",
    "decide_at": 0.995,
    "console": {"pictures_skipped": 0, "clients": 1},
}  # fmt: skip

PROPOSED = {
    "kind": "warm",
    "kinds": {
        kind: {"text": "no different from its surroundings (1.02 ± 0.04 times)", "confidence": "low"}
        for kind in ("rough", "cold", "stiff", "soft")
    }
    | {"warm": {"text": "+3.4 ± 0.3 K against 33.0 ± 0.2 °C around it (31 touches)", "confidence": "high"}},
    "text": "no different from its surroundings (temperature +0.1 ± 0.4 K)",
}
FINDINGS = [
    {"id": 1, "at_s": 311.0, "kind": "warm", "x_mm": 40.0, "y_mm": -20.0, "finger": "index",
     "text": "warm, 36.4 ± 0.2 °C", "contrast": "+3.4 ± 0.3 K", "note": "", "saved": True},
    {"id": 2, "at_s": 402.0, "kind": "stiff", "x_mm": -30.0, "y_mm": 20.0, "finger": "ring",
     "text": "stiff, 4000 ± 400 N/m", "contrast": "10 ± 1 times", "note": "moves a little", "saved": True},
]  # fmt: skip


def _converging(finger: dict[str, Any], contact_s: float) -> dict[str, Any]:
    """The same finger at an earlier or later moment of its contact: probabilities and temperature settle."""
    settled = 1.0 - math.exp(-contact_s / 0.6)
    count = len(finger["candidates"]) + 3
    candidates = [[name, settled * share + (1 - settled) / count] for name, share in finger["candidates"]]
    sd = finger["object_c_sd"]
    return finger | {
        "contact_s": contact_s, "candidates": candidates, "object_c": finger["object_c"] + 3.0 * (1 - settled),
        "object_c_sd": None if sd is None else sd + 3.0 * (1 - settled),
    }  # fmt: skip


class Scenario:
    """A state of the console that a page can be shown: `state` goes out as JSON, the rest shapes the pictures."""

    def __init__(self) -> None:
        self.converges = False
        """Whether fingers in contact are shown converging since the page was connected."""
        self.state: dict[str, Any] = deepcopy(BASE)
        self.touching: set[int] = set()
        self.limited: set[int] = set()
        self.absent: set[int] = set()
        self.stale: set[int] = set()
        self.age_s = 0.6
        self.sends = True
        """Whether pictures and states go out at all."""

    def at(self, seconds: float) -> dict[str, Any]:
        """The state `seconds` after a page was connected."""
        if not self.converges:
            return self.state
        fingers = [
            _converging(finger, min(seconds, finger["contact_s"])) if finger["contact_s"] else finger
            for finger in self.state["fingers"]
        ]
        return self.state | {"fingers": fingers}

    def shows(self, **changed: Any) -> "Scenario":
        """Change parts of the state."""
        self.state.update(changed)
        return self

    def session(self, **changed: Any) -> "Scenario":
        """Change the session's part of the state."""
        self.state["session"].update(changed)
        return self

    def alarm(self, ident: str, priority: str, text: str, **more: Any) -> "Scenario":
        """Raise one more alarm."""
        usual = {"since_s": 700.0, "since": "14:06:01", "age_s": 61.2, "active": True}
        usual |= {"ended_s": None, "cleared_by": None, "waits": False}
        self.state["alarms"].append({"id": ident, "priority": priority, "text": text} | usual | more)
        return self


def _at_work(state: str) -> Scenario:
    scenario = Scenario().session(state=state, clock_s=761.2, pseudonym="P-0417", recording=True, sound="heard")
    scenario.state["findings"] = deepcopy(FINDINGS)
    return scenario


def disconnected() -> Scenario:
    """No remote site, two devices missing, nothing calibrated: first run."""
    scenario = Scenario().session(state="disconnected")
    scenario.state["link"] = {"delay_ms": None, "delay_sd_ms": None, "age_ms": None, "loss": None}
    devices, checks = scenario.state["devices"], scenario.state["checks"]
    for part, text, remedy in (
        (devices[3], "Ring module absent. Check its cable, then:", "teletaction doctor --config operator.toml"),
        (devices[6], "Remote site does not answer. Start it:", "teletaction remote --config remote.toml"),
        (checks[0], "Not calibrated. Materials stay UNKNOWN.", "teletaction calibrate --config remote.toml"),
        (checks[1], "Key of the remote site is refused.", "teletaction keys trust remote.key"),
    ):
        part.update(ready=False, text=text, help=remedy)
    scenario.state["meaning"] = None
    scenario.absent = {3}
    return scenario.alarm("calibration", "low", "Not calibrated: materials stay unknown.")


def connected() -> Scenario:
    """Ready to begin a session."""
    return Scenario()


def ready() -> Scenario:
    """A session was begun and not yet engaged."""
    return _at_work("connected")


def engaging() -> Scenario:
    """Asked for, not yet agreed."""
    return _at_work("engaging")


def engaged() -> Scenario:
    """The state in which most work is done."""
    scenario = _at_work("engaged")
    scenario.converges = True
    scenario.touching = {1, 2}
    scenario.state["fingers"][1] |= IDENTIFIED
    scenario.state["fingers"][2] |= IDENTIFIED | {"contact_s": 5.0}
    return scenario


def clutched() -> Scenario:
    """The clutch is open at a scale of 1:5, close to two edges of the remote hand's workspace."""
    return engaged().shows(coupling={"open": True, "scale": 5, "edges": ["x+", "low"]})


def watching() -> Scenario:
    """The camera's picture is seen, reduced for touch."""
    return engaged().shows(camera={"seen": "live", "reduced": True, "stills": True})


def talking() -> Scenario:
    """The remote site is heard, and the sound of both sides is recorded."""
    return engaged().shows(voice={"heard": "live", "hears": True, "recorded": True, "talker": ""})


def unheard() -> Scenario:
    """The remote microphone is muted, and another page talks."""
    scenario = observer()
    scenario.state["you"] |= {"name": "student 2"}
    scenario.state["voice"] = {"heard": "muted", "hears": True, "recorded": False, "talker": "OR-1 1"}
    return scenario


def unseen() -> Scenario:
    """The remote site has no camera, and the configuration requires one."""
    return (
        paused()
        .shows(camera={"seen": "no_camera", "reduced": False, "stills": True})
        .alarm("camera", "medium", "No camera at the remote site. Session pauses.")
    )


def painful() -> Scenario:
    """The patient has reported pain, and the force is limited."""
    return engaged().shows(
        patient={
            "pain": 6.0,
            "age_s": 0.2,
            "limit": "Force limited to 2.1 N by the patient's threshold.",
            "ends": "Remote side asks patient, then: teletaction session restore-force.",
            "reports": [[20.0, 10.0, 2.6, 6.0]],
            "tender": {
                "text": "Most tender near x 14 y 4 mm, ± 3 mm; pain from about 2.1 N; reaction about 0.6 s.",
                "circle": [14.0, 4.0, 7.4],
            },
            "agreed": True,
        }
    )


def shifted() -> Scenario:
    """The patient has moved under the map; its left part was felt before."""
    scenario = engaged()
    scenario.state["map"]["moved"] = "Patient moved by about 5 mm towards the hand. Striped: felt before."
    scenario.state["map"]["stale_mm"] = [[x, y] for x in range(-70, 10, 4) for y in range(-44, 44, 4)]
    return scenario


def ambiguous() -> Scenario:
    """Two materials that cannot be distinguished."""
    scenario = engaged()
    scenario.state["fingers"][1] |= {
        "decision": "AMBIGUOUS",
        "line": "PVC or acrylic",
        "candidates": [["PVC", 0.48], ["acrylic", 0.46], ["rubber", 0.03]],
        "object_c_sd": None,
    }
    return scenario


def unknown() -> Scenario:
    """Matches nothing calibrated, on a plate held at its limit."""
    scenario = engaged()
    scenario.limited = {1}
    scenario.state["fingers"][1] |= {
        "decision": "UNKNOWN",
        "line": "matches nothing calibrated",
        "candidates": [["PVC", 0.2], ["acrylic", 0.1]],
        "object_c": 31.2,
        "object_c_sd": 2.1,
        "object_c_uncertain": True,
    }
    return scenario.alarm("plate-index", "medium", "Index: plate at 42.0 °C, held at its limit. Lift the finger.")


def cannot_identify() -> Scenario:
    """The remote site cannot identify the material, and gives the reason."""
    scenario = engaged()
    answer = {"decision": "CANNOT IDENTIFY", "line": "no temperature difference", "candidates": []}
    scenario.state["fingers"][1] |= answer
    return scenario


def paused() -> Scenario:
    """Neutral, the session still open."""
    scenario = _at_work("paused")
    return scenario.alarm("disk", "low", "Disk 91 % full.")


def alarmed() -> Scenario:
    """The longest alarm, beside one that a person has yet to acknowledge: all buttons of the alarm line."""
    scenario = _at_work("paused")
    scenario.alarm("device", "high", "STOP NOT CONFIRMED: Index, remote hand. Use the hardware switch.")
    return scenario.alarm("link", "high", "Link was lost: session ended. Acknowledge (K).", active=False, waits=True)


def fault() -> Scenario:
    """The link was lost while engaged."""
    scenario = _at_work("fault").session(recording=True)
    scenario.state["link"] = {"delay_ms": None, "delay_sd_ms": None, "age_ms": 1400.0, "loss": 1.0}
    scenario.stale = {0, 1, 2, 3, 4}
    scenario.age_s = 1.4
    scenario.alarm("link", "high", "LINK LOST. Outputs are neutral. Wait for the link.")
    scenario.alarm("slow", "medium", "Link slow: 210 ± 8 ms. Move slowly.", active=False, ended_s=712.0)
    return scenario.alarm("disk", "low", "Disk 91 % full.")


def lost() -> Scenario:
    """The link has been silent for a moment, and both sites are still engaged."""
    scenario = engaged().session(state="lost")
    return scenario.alarm("link", "high", "LINK LOST. Outputs are neutral. Wait for the link.")


def stop_of(times: dict[str, float | None], *, late: bool) -> dict[str, Any]:
    """The state of a STOP; devices that are not in `times` have not answered."""
    found = {name: times.get(name) for name in DEVICES}
    return {
        "asked_s": 761.2,
        "devices": found,
        "confirmed": all(time is not None for time in found.values()),
        "late": late,
    }


def stopping() -> Scenario:
    """STOP is on its way: four devices have answered."""
    return _at_work("engaged").shows(stop=stop_of(dict.fromkeys(DEVICES[:4], 0.06), late=False))


def stopped() -> Scenario:
    """STOP, confirmed by all seven devices."""
    return _at_work("stopped").shows(
        stop=stop_of({name: 0.05 + 0.006 * number for number, name in enumerate(DEVICES)}, late=False)
    )


def stop_not_confirmed() -> Scenario:
    """STOP, and two devices do not answer."""
    return (
        _at_work("fault")
        .shows(stop=stop_of({name: 0.06 for name in DEVICES if name not in ("index", "remote hand")}, late=True))
        .alarm("stop", "high", "STOP NOT CONFIRMED: Index, remote hand. Use the hardware switch.")
    )


def missing_devices() -> Scenario:
    """Two finger modules absent during work, two fingers' data old, and no standard deviation of their temperature."""
    scenario = engaged()
    scenario.absent = {3, 4}
    scenario.stale = {1, 2}
    scenario.state["fingers"][1] |= {"object_c_sd": None, "limits": ["stiffness", "plate range"]}
    for finger in (3, 4):
        scenario.state["fingers"][finger] |= {"in_use": False}
    return scenario.alarm("module-ring", "medium", "Ring module lost. Ring feels nothing.").alarm(
        "module-little", "medium", "Little module lost. Little feels nothing."
    )


def observer() -> Scenario:
    """Looking on: nothing here acts."""
    return engaged().shows(you={"role": "observe", "in_control": False, "control": "OR-2"})


def elsewhere() -> Scenario:
    """Another console acts."""
    return ready().shows(you={"role": "act", "in_control": False, "control": "OR-2"})


def playback() -> Scenario:
    """A recording."""
    scenario = engaged().session(
        recording=False, title="3 Nov 2026 14:07",
        playback={"at_s": 312.4, "length_s": 761.2, "speed": 1.0, "playing": True,
                  "partial": False,
                  "marks": [{"at_s": 2.0, "kind": "mode", "text": "connected"},
                            {"at_s": 60.0, "kind": "mode", "text": "engaged"},
                            {"at_s": 120.0, "kind": "alarm", "text": "Link slow"},
                            {"at_s": 311.0, "kind": "finding", "text": "1: warm, 36.4 ± 0.2 °C"},
                            {"at_s": 402.0, "kind": "finding", "text": "2: stiff, 4000 ± 400 N/m"},
                            {"at_s": 500.0, "kind": "fault", "text": "index plate 45.2 °C, over 45.0"},
                            {"at_s": 500.0, "kind": "mode", "text": "fault"}]},
    )  # fmt: skip
    scenario.state["you"] = {"role": "observe", "in_control": False, "control": "recording"}
    return scenario


def ended() -> Scenario:
    """After a session: saved, with its report."""
    scenario = Scenario().session(
        state="connected",
        saved={"text": "Saved: 12 min 41 s, 3 findings, 0 gaps.", "report": "/report/P-0417.html"},
        sound="heard",
    )
    scenario.state["findings"] = deepcopy(FINDINGS)
    scenario.state["findings"][1]["saved"] = False
    return scenario


def silent() -> Scenario:
    """The console has fallen silent while fingers were driven."""
    scenario = engaged()
    scenario.sends = False
    return scenario


SCENARIOS = {
    made.__name__: made
    for made in (
        disconnected, connected, ready, engaging, engaged, clutched, watching, unseen, talking, unheard, painful,
        shifted, lost, ambiguous, unknown, cannot_identify, paused,
        alarmed,
        fault, stopping, stopped, stop_not_confirmed, missing_devices, observer, elsewhere, playback, ended, silent,
    )
}  # fmt: skip
