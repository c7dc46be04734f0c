"""Grooves over a network: their displayed spacing, played on arrival and at their time behind the hand.

A hand strokes evenly over a grating. The remote finger follows the newest motion packet with a lag. It finds a groove
in the chunk of 5 ms in which it crosses it. Packets of either direction jitter and keep their order; some are lost.
"""

import math
from collections.abc import Iterator, Sequence
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from common.wire.messages import Event, EventKind
from operator_site.vibration.grooves import GrooveTiming
from operator_site.vibration.vibration import PlayedEvents
from remote_site.devices.sensor_frame import HandPlace
from remote_site.identification.touch_events import HandPath
from studies.compared import Compared
from studies.pieces import HERE, Piece, Work, rows_of
from studies.running import Progress, tables_of

Floats = NDArray[np.float64]

TICK_S, STEP_S, CHUNK_STEPS = 0.002, 0.001, 5
LAG_S = 0.020
"""Time constant of the telemanipulator, s."""
DELAY_S = 0.030
STROKE_M_S, GROOVES_M = 0.060, 0.004
SECONDS, SETTLED_S = 30.0, 3.0
HISTORY_S = 0.25
JITTERS_S = (0.0, 0.002, 0.005, 0.010, 0.015, 0.020, 0.030)
LOSSES = (0.0, 0.2)
AS_THEY_COME, AT_THEIR_TIME = "as they come", "at their time"
tables = tables_of("spacing")
COMPARED = (
    Compared("spacing", "spacing_sd_mm", "less", ("way", "jitter_ms", "loss"), absolute=0.02, relative=0.1),
    Compared("spacing", "behind_ms", "less", ("way", "jitter_ms", "loss"), absolute=2.0, relative=0.05),
    Compared("spacing", "felt", "more", ("way", "jitter_ms", "loss"), absolute=1.0),
)


def run(quick: bool, seed: int, progress: Progress, work: Work = HERE) -> dict[str, Any]:
    """A row for each network and way: standard deviation of the spacing, and lag behind the hand."""
    networks = product(LOSSES, JITTERS_S[:: 3 if quick else 1])
    pieces: dict[str, list[Piece]] = {"spacing": [(_rows, (jitter, loss, seed)) for loss, jitter in networks]}
    found = rows_of(pieces, work, progress)
    return {"grooves_mm": 1e3 * GROOVES_M, "stroke_mm_s": 1e3 * STROKE_M_S, **found}


def _rows(jitter_s: float, loss: float, seed: int) -> Iterator[dict[str, Any]]:
    rng = np.random.default_rng([seed, round(1e4 * jitter_s), round(100 * loss)])
    events, ready_s = _crossed(jitter_s, loss, rng)
    arrived_s = _arrivals(np.arange(0.0, SECONDS, TICK_S), jitter_s, loss, rng)
    for way, timing in ((AS_THEY_COME, None), (AT_THEIR_TIME, GrooveTiming())):
        played = _played(events, ready_s, arrived_s, timing)
        hand_s = np.array([event.ident * GROOVES_M / STROKE_M_S for event in events])
        settled = [n for n, event in enumerate(events) if hand_s[n] > SETTLED_S and event.ident in played]
        at_s = np.array([played[events[n].ident] for n in settled])
        yield {
            "way": way,
            "jitter_ms": 1e3 * jitter_s,
            "loss": loss,
            "grooves": len(events),
            "felt": len(played),
            "spacing_sd_mm": 1e3 * STROKE_M_S * float(np.diff(at_s).std()),
            "behind_ms": 1e3 * float((at_s - hand_s[settled]).mean()),
        }


def _arrivals(sent_s: Floats, jitter_s: float, loss: float, rng: np.random.Generator) -> Floats:
    """Arrival time of each packet, s, infinite for a lost one; none overtakes another."""
    there = sent_s + np.maximum(0.0, DELAY_S + rng.uniform(-jitter_s, jitter_s, sent_s.size))
    return np.where(rng.random(sent_s.size) < loss, np.inf, np.maximum.accumulate(there))


def _crossed(jitter_s: float, loss: float, rng: np.random.Generator) -> tuple[list[Event], list[float]]:
    """Grooves as the remote site finds them, numbered from the start of the grating, and when it finds them, s."""
    sent_s = np.arange(0.0, SECONDS, TICK_S)
    there_s = _arrivals(sent_s, jitter_s, loss, rng)
    order = np.flatnonzero(np.isfinite(there_s))
    hand, events, ready = HandPath(), list[Event](), list[float]()
    crossed, x_m, newest_s, k = 0, 0.0, 0.0, 0
    for tick, now_s in enumerate(np.arange(0.0, SECONDS, STEP_S)):
        while k < len(order) and there_s[order[k]] <= now_s:
            newest_s = float(sent_s[order[k]])
            hand.step(HandPlace(round(1e9 * newest_s), STROKE_M_S * newest_s, 0.0))
            k += 1
        x_m += (STROKE_M_S * newest_s - x_m) * (1.0 - math.exp(-STEP_S / LAG_S))
        while tick % CHUNK_STEPS == 0 and (crossed + 1) * GROOVES_M <= x_m:
            crossed += 1
            over_ns = hand.when_ns(crossed * GROOVES_M, 0.0)
            events.append(Event(crossed, EventKind.GROOVE, 0, round(1e9 * now_s), over_ns, 400.0))
            ready.append(float(now_s))
    return events, ready


def _played(
    events: Sequence[Event], ready_s: Sequence[float], arrived_s: Floats, timing: GrooveTiming | None
) -> dict[int, float]:
    """Time at which each groove is played, s; a packet reports the grooves found in the last HISTORY_S."""
    played, found = PlayedEvents(), dict[int, float]()
    packets = sorted((there, n * TICK_S) for n, there in enumerate(arrived_s) if np.isfinite(there))
    k = first = 0
    for now_s in np.arange(0.0, SECONDS, TICK_S):
        fresh: list[Event] = []
        while k < len(packets) and packets[k][0] <= now_s:
            sent_s = packets[k][1]
            while first < len(events) and ready_s[first] < sent_s - HISTORY_S:
                first += 1
            last = first
            while last < len(events) and ready_s[last] <= sent_s:
                last += 1
            fresh += played.new(events[first:last])
            k += 1
        for event in fresh if timing is None else timing.step(float(now_s), fresh):
            found[event.ident] = float(now_s)
    return found
