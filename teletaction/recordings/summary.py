"""Computes `summary.json`: a session's figures, measured at the simulated devices."""

import math
from bisect import bisect_left
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from common.exploration.contact_detector import BOUNCE_S
from common.fingers import FINGERS, chosen_fingers
from common.limits import MOTOR_STILL_S
from common.scenes.scene import SceneObject
from common.wire.messages import EventKind, ExplorationMode, ThermalStatus
from teletaction.recordings.columns import Floats
from teletaction.recordings.incidents import faults, incomplete_recordings, interruptions
from teletaction.recordings.session_data import SessionData
from teletaction.recordings.true_touches import SHORTEST_TOUCH_S, Touch, true_touches

MODES = tuple(mode.name.lower() for mode in ExplorationMode)
PAPER_S = 8.0
"""Time after contact up to which an answer of the paper's method counts, s. It answers after 5 to 8 s."""
_FOLLOWS_S = 0.3
"""Largest delay from a contact to the vibration that belongs to it, s."""
_NOISE_S = 0.020
"""Largest lead of a detected contact before the true one, s.

On soft ground the force rises slowly through 0.30 N, and the sensor's noise crosses this threshold early.
"""
_GROOVE_EARLY_S, _GROOVE_LATE_S = 0.005, 0.035
"""Range of a played impulse's source time around the crossing of its groove: before and after it, s."""


def summarise(
    data: SessionData,
    statuses: Mapping[str, Mapping[str, Any]],
    network: Mapping[str, Any] | None,
    usage: Mapping[str, tuple[float, float]],
    wall_s: float,
    round_trips_s: list[float],
    *,
    scene: str,
    objects: Sequence[SceneObject],
    seed: int,
    fingers: int,
) -> dict[str, Any]:
    """Compute the summary of a session.

    Args:
        data: the merged recording.
        statuses: the last status of each process.
        network: the last status of the simulated network; None without one.
        usage: CPU share (of one core) and peak memory (MiB) of each process during the exploration.
        wall_s: duration of the exploration, s.
        round_trips_s: round trips of the bare ping, s.
        scene: name or file of the scene.
        objects: its objects, in its order.
        seed: seed of the simulation.
        fingers: number of fingers in use, 1..5.
    """
    used = [FINGERS.index(finger) for finger in chosen_fingers(fingers)]
    remote, operator = statuses["remote"], statuses["operator"]
    return {
        "duration_s": round(wall_s, 1),
        "scene": scene,
        "seed": seed,
        "fingers": fingers,
        "network": None if network is None else network["network"],
        "proxy": proxy(network),
        "contacts": contacts(data, objects),
        "modes": modes(data, used),
        "impulses": impulses(data, [thing.name for thing in objects]),
        "taps": taps(data),
        "vibration_rpm": still_vibration(data, used),
        "latency_ms": {
            "contact_to_motor": _spread(contact_to_motor_s(data)),
            "link_one_way": _spread(one_way_s(data)),
            "bare_curve_ping": _spread(round_trips_s),
        },
        "plate_c": _range(data.fingertips, "plate_c", used, ("min", "max")),
        "sensor_plate_c": _range(data.contact, "plate_c", used, ("max",)),
        "force_n": _range(data.fingertips, "force_n", used, ("max",)),
        "contact_force_n": _range(data.contact, "force_n", used, ("max",)),
        "loop": {
            name: dict(status["loop"])
            | {"cpu": round(usage.get(name, (0.0, 0.0))[0], 3), "behind_s": status.get("behind_s")}
            | ({"postponed": status["postponed"]} if "postponed" in status else {})
            for name, status in statuses.items()
        },
        "cpu_cores": round(sum(cpu for cpu, _ in usage.values()), 3),
        "rss_mib": {name: round(peak, 1) for name, (_, peak) in usage.items()},
        "packets": {
            "touch": _packets("touch", remote, operator),
            "motion": _packets("motion", operator, remote),
        },
        "recorded": data.counts,
        "faults": [*faults(data), *incomplete_recordings(data, statuses)],
        "interruptions": interruptions(data),
    }


def proxy(status: Mapping[str, Any] | None) -> dict[str, Any] | None:
    """Return the counts and faults of the simulated network; None without one."""
    return None if status is None else {name: status[name] for name in ("streams", "faults")}


def contacts(data: SessionData, objects: Sequence[SceneObject]) -> list[dict[str, Any]]:
    """List each touch of at least SHORTEST_TOUCH_S with the true and the identified values.

    A touch that slides to another piece is judged by what was identified before.
    """
    found = []
    borders = [_borders(data, finger) for finger in range(len(FINGERS))]
    for whole in _touches(data):
        touch = replace(whole, end_s=_leaves_s(whole, borders[whole.finger], objects))
        if touch.end_s - touch.start_s < SHORTEST_TOUCH_S:
            continue
        answers = data.answers(touch.finger, touch.start_s + 0.05, touch.end_s)
        last = answers[-1] if answers else {}
        status = ThermalStatus(last.get("status", 0))
        named = next((a["time_s"] for a in answers if a["status"] == ThermalStatus.IDENTIFIED), None)
        paper = [a["exponential_material"] for a in answers if a["time_s"] <= touch.start_s + PAPER_S]
        found.append(
            {
                "finger": FINGERS[touch.finger],
                "object": touch.thing,
                "true_material": touch.material,
                "material": last.get("best") if status is ThermalStatus.IDENTIFIED else None,
                "best": last.get("best"),
                "status": status.name.lower(),
                "reason": last.get("reason"),
                "probability": _rounded(last.get("probability"), 4),
                "seconds": None if named is None else round(named - touch.start_s, 2),
                "held_s": round(touch.end_s - touch.start_s, 2),
                "true_object_c": round(touch.object_c, 2),
                "object_c": _rounded(last.get("object_c"), 2),
                "object_c_sd": _rounded(last.get("object_c_sd"), 2),
                "paper_material": paper[-1] if paper else None,
                "paper_object_c": _rounded(last.get("exponential_object_c"), 2),
            }
        )
    return found


def modes(data: SessionData, used: Iterable[int]) -> dict[str, Any]:
    """Compare the identified mode with the true one every 10 ms, over all fingers."""
    confusion = {true: Counter[str]() for true in MODES}
    if len(data.touch) and len(data.contact):
        newest = np.searchsorted(data.touch.time_s, data.contact.time_s, side="right") - 1
        known = newest >= 0
        for finger in used:
            true = data.contact["mode"][known, finger].astype(int)
            identified = data.touch["mode"][newest[known], finger].astype(int)
            for (t, o), count in Counter(zip(true.tolist(), identified.tolist(), strict=True)).items():
                confusion[MODES[t]][MODES[o]] += count
    total = sum(sum(row.values()) for row in confusion.values())
    agree = sum(confusion[mode][mode] for mode in MODES)
    in_contact = {true: row for true, row in confusion.items() if true != "free"}
    contact_total = sum(sum(row.values()) for row in in_contact.values())
    contact_agree = sum(row[true] for true, row in in_contact.items())
    return {
        "agreement": round(agree / total, 4) if total else None,
        "agreement_in_contact": round(contact_agree / contact_total, 4) if contact_total else None,
        "confusion": {true: dict(row) for true, row in confusion.items() if row},
    }


def impulses(data: SessionData, things: Sequence[str]) -> dict[str, Any]:
    """Compare what the true fingertips crossed with impulses displayed to the operator, also by object.

    An impulse belongs to a groove, or else to an edge, which is a border of two objects; without both it is invented.
    """
    sent = _by(data.sent_events, "ident")
    shown = [
        event
        for p in data.played
        if p["kind"] == EventKind.GROOVE and (event := _newest(sent[p["ident"]], p)) is not None
    ]
    counts = ("crossed", "played", "edges", "missed", "invented")
    by_object: dict[str, dict[str, int]] = defaultdict(lambda: dict.fromkeys(counts, 0))
    grooves = _by((event for event in data.truth_events if event["kind"] == "groove"), "finger")
    for finger in range(len(FINGERS)):
        crossed = [(event["time_s"], event["object"]) for event in grooves[finger]]
        played = sorted(e["time_ns"] * 1e-9 for e in shown if e["finger"] == finger)
        matched, left_s = _match([t for t, _ in crossed], played)
        for (_, thing), hit in zip(crossed, matched, strict=True):
            by_object[thing]["crossed"] += 1
            by_object[thing]["played" if hit else "missed"] += 1
        borders = _borders(data, finger)
        matched, invented_s = _match([t for t, _, _ in borders], left_s)
        causes = [(_name(things, index), "edges") for (_, _, index), hit in zip(borders, matched, strict=True) if hit]
        causes += [(_object_under(data, things, finger, time_s), "invented") for time_s in invented_s]
        for thing, cause in causes:
            by_object[thing]["played"] += 1
            by_object[thing][cause] += 1
    total = {name: sum(row[name] for row in by_object.values()) for name in counts}
    return {**total, "by_object": dict(by_object)}


def taps(data: SessionData) -> dict[str, int]:
    """Count contacts of the true fingertips, and those that were displayed to the operator as a tap."""
    made = _by(_contacts_made(data), "finger")
    shown = _by((p for p in data.played if p["kind"] == EventKind.TAP), "finger")
    played = 0
    for finger, events in made.items():
        shown_s = [p["time_s"] for p in shown[finger]]
        played += sum(_match([event["time_s"] for event in events], shown_s, _NOISE_S, _FOLLOWS_S)[0])
    return {"made": sum(map(len, made.values())), "played": played}


def still_vibration(data: SessionData, used: Iterable[int]) -> dict[str, float | None]:
    """Return the largest motor speed, rpm, at fingertips truly free or resting for at least MOTOR_STILL_S."""
    fastest: dict[str, float | None] = {"free_max": None, "resting_max": None}
    if not len(data.contact) or not len(data.fingertips):
        return fastest
    nearest = np.searchsorted(data.fingertips.time_s, data.contact.time_s).clip(0, len(data.fingertips) - 1)
    for name, mode in (("free_max", ExplorationMode.FREE), ("resting_max", ExplorationMode.QUIESCENT)):
        speeds = [0.0]
        for finger in used:
            still = _lasting(data.contact["mode"][:, finger] == mode, data.contact.time_s, MOTOR_STILL_S)
            speeds += data.fingertips["motor_rpm"][nearest[still], finger].tolist()
        fastest[name] = round(max(speeds), 1)
    return fastest


def contact_to_motor_s(data: SessionData) -> list[float]:
    """Return the delays from 0.30 N at the true fingertip to the first motor command in its module, s."""
    switched_on_s = {
        finger: [switch["time_s"] for switch in switches]
        for finger, switches in _by((each for each in data.motor_switches if each["motor_mv"] > 0), "finger").items()
    }
    delays = []
    for event in _contacts_made(data):
        times_s = switched_on_s.get(event["finger"], [])
        first = bisect_left(times_s, event["time_s"] - _NOISE_S)
        if first < len(times_s) and times_s[first] - event["time_s"] < _FOLLOWS_S:
            delays.append(times_s[first] - event["time_s"])
    return delays


def one_way_s(data: SessionData) -> list[float]:
    """Return the delays from a touch packet's source time to the sending of its rendering to the modules, s.

    For two hosts, each delay has the error of the offset between their clocks.
    """
    if not len(data.rendered) or not len(data.touch):
        return []
    sequence, written_s = data.rendered["sequence"], data.rendered["written_s"]
    sent: dict[float, list[float]] = {}
    for number, time_s in zip(data.touch["sequence"].tolist(), data.touch.time_s.tolist(), strict=True):
        sent.setdefault(number, []).append(time_s)
    delays = []
    for i in np.flatnonzero(np.diff(sequence, prepend=np.nan) > 0).tolist():
        # A restarted site counts from the start again, so the newest earlier packet of this number was consumed.
        before = [time_s for time_s in sent.get(float(sequence[i]), []) if time_s <= written_s[i]]
        if before:
            delays.append(float(written_s[i]) - before[-1])
    return delays


def _contacts_made(data: SessionData) -> Iterator[dict[str, Any]]:
    """Yield the contacts of the true fingertips, in order of time.

    A contact within BOUNCE_S of the release does not count: the force has only dipped.
    """
    left_s = dict.fromkeys(range(len(FINGERS)), -math.inf)
    for event in data.truth_events:
        if event["kind"] == "release":
            left_s[event["finger"]] = event["time_s"]
        elif event["kind"] == "contact" and event["time_s"] - left_s[event["finger"]] >= BOUNCE_S:
            yield event


def _by(events: Iterable[dict[str, Any]], name: str) -> dict[int, list[dict[str, Any]]]:
    """Group events by a field, in order of time."""
    found: dict[int, list[dict[str, Any]]] = defaultdict(list)
    for event in events:
        found[event[name]].append(event)
    return found


def _newest(same: list[dict[str, Any]], played: Mapping[str, Any]) -> dict[str, Any] | None:
    """Return the event that was played, of those of its number.

    A restarted site counts from the start again, so the newest earlier event of this number was played.
    """
    before = [event for event in same if event["time_ns"] * 1e-9 <= played["time_s"]]
    return before[-1] if before else None


def _touches(data: SessionData) -> list[Touch]:
    return true_touches(data.truth_events, float(data.contact.time_s[-1]) if len(data.contact) else 0.0)


def _match(
    true_s: list[float], shown_s: list[float], early_s: float = _GROOVE_EARLY_S, late_s: float = _GROOVE_LATE_S
) -> tuple[list[bool], list[float]]:
    """Match true events with displayed ones in order of time, each at most once.

    Returns for each true event if it was displayed, and the times of the displayed ones that are left, s.
    """
    left = list(shown_s)
    matched = []
    for time_s in true_s:
        hit = next((p for p in left if -early_s <= p - time_s <= late_s), None)
        if hit is not None:
            left.remove(hit)
        matched.append(hit is not None)
    return matched, left


def _borders(data: SessionData, finger: int) -> list[tuple[float, int, int]]:
    """Return when a finger slid from one object to another, s, to 10 ms, and the indices of both objects."""
    if not len(data.contact):
        return []
    time_s, under = data.contact.time_s, data.contact["object"][:, finger].astype(int)
    left = np.flatnonzero((under[1:] != under[:-1]) & (under[1:] >= 0) & (under[:-1] >= 0)).tolist()
    return [(float(time_s[at]), int(under[at]), int(under[at + 1])) for at in left]


def _leaves_s(touch: Touch, borders: Sequence[tuple[float, int, int]], objects: Sequence[SceneObject]) -> float:
    """Return when a touch ends or slides to another material or another body, s."""
    for time_s, before, after in borders:
        if touch.start_s <= time_s < touch.end_s and max(before, after) < len(objects):
            one, other = objects[before], objects[after]
            if one.material != other.material or one.body is None or one.body != other.body:
                return time_s
    return touch.end_s


def _object_under(data: SessionData, things: Sequence[str], finger: int, time_s: float) -> str:
    """Name the object that a finger touches at a time, s."""
    newest = int(np.searchsorted(data.contact.time_s, time_s, side="right")) - 1 if len(data.contact) else -1
    return _name(things, int(data.contact["object"][newest, finger]) if newest >= 0 else -1)


def _name(things: Sequence[str], index: int) -> str:
    return things[index] if 0 <= index < len(things) else "nothing"


def _lasting(condition: "np.ndarray[Any, np.dtype[np.bool_]]", time_s: Floats, least_s: float) -> Any:
    """Mark the samples at which a condition has held for at least `least_s`."""
    since = np.where(condition, np.nan, time_s)
    started = np.fmax.accumulate(np.concatenate(([time_s[0]], since[1:])))
    return condition & (time_s - started >= least_s)


def _spread(seconds: list[float]) -> dict[str, float | int | None]:
    """Return p50, p99 and maximum in ms, and the count."""
    if not seconds:
        return {"p50": None, "p99": None, "max": None, "count": 0}
    ms = np.array(seconds) * 1e3
    p50, p99 = np.percentile(ms, (50, 99))
    return {
        "p50": round(float(p50), 3),
        "p99": round(float(p99), 3),
        "max": round(float(ms.max()), 3),
        "count": len(seconds),
    }


def _range(series: Any, name: str, used: list[int], ends: tuple[str, ...]) -> dict[str, float | None]:
    if not len(series):
        return dict.fromkeys(ends)
    values = series[name][:, used]
    return {end: round(float(getattr(values, end)()), 3) for end in ends}


def _packets(stream: str, sender: Mapping[str, Any], receiver: Mapping[str, Any]) -> dict[str, Any]:
    refused = sum(receiver["refused"][stream].values()) + receiver["refused"]["damaged"].get(stream, 0)
    return {
        "sent": sender["sent"][stream],
        "received": receiver["received"][stream],
        "superseded": receiver["superseded"][stream],
        "refused": refused,
    }


def _rounded(value: float | None, digits: int) -> float | None:
    return None if value is None else round(value, digits)
