"""One-way time of a touch packet between two processes: the product's link beside bare CurveZMQ and plain TCP.

All ways carry messages of one size at one rate, in short blocks in random order. Other load on the machine thus affects
all alike. The time of a packet ends when it is decoded, checked and accepted. It begins after its encoding, and in a
second row before its encoding. The time of a bare message is that of its socket alone.

Sockets in processes that do nothing else find the processor as they left it, and no site is such a process. A
further pair therefore encodes a packet before each message and decodes one after it, outside the measured time.
"""

import time
from collections.abc import Callable, Mapping, Sequence
from multiprocessing.connection import Connection
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import zmq

from benchmarks.link.bare import BareCurve, PlainTcp
from benchmarks.link.ends import EndLost, Place, ends, pipe
from benchmarks.link.packets import USUAL_EVENTS, next_touch, touch_parts
from benchmarks.link.ways import Arrival, Receiver, Sender, bare_receiver, bare_sender, link_receiver, link_sender
from common.link.keys import load_keys
from common.runtime.periodic_loop import PeriodicLoop
from common.wire.streams import STREAMS

LINK, CURVE, TCP = "link, encoded to checked", "bare CurveZMQ", "plain TCP"
BUSY_CURVE = "bare CurveZMQ, ends as busy"
WAYS = (LINK, BUSY_CURVE, CURVE, TCP)
WITH_ENCODING = "link, with its encoding"
BLOCK = 50
"""Messages of one way before the next way's turn: a tenth of a second."""
GRID = np.round(np.linspace(0.0, 0.999, 334), 4)
"""Shares at which a distribution is kept for the figure."""
_GIVE_UP_S = 0.5
_TRIES = 60


def _send(line: Connection, place: Place, receiver: Connection, seed: int, rounds: int) -> None:
    """Sending process: chooses the way of each block, and reports the time that each message took."""
    like = touch_parts()
    body = next_touch(like, 10_000, time.monotonic_ns()).encode()
    curve = BareCurve(place.bare_address(0), zmq.PUB, load_keys(place.remote_keys))
    senders: dict[str, Sender] = {
        LINK: link_sender(place, like),
        BUSY_CURVE: bare_sender(curve, body, like),
        CURVE: bare_sender(curve, body),
        TCP: bare_sender(PlainTcp.serve(place.host, place.bare_port(1)), body),
    }
    loop = PeriodicLoop(1.0 / STREAMS["touch"].rate_hz)
    chance, sequence = Random(seed), 0
    for turn in range(-1, rounds):
        for way in chance.sample(WAYS, len(WAYS)):
            for _ in range(_TRIES):
                receiver.send((way, sequence + BLOCK))
                receiver.recv()
                departures = {}
                for _ in range(BLOCK):
                    loop.wait()
                    sequence += 1
                    departures[sequence] = senders[way].send(sequence)
                arrivals: list[Arrival] = receiver.recv()
                if arrivals:
                    break
            else:
                raise EndLost(f"{way}: nothing arrived")
            if turn >= 0:  # the turn before only shows that all are connected
                taken = [(arrived_ns, *departures[n]) for n, arrived_ns in arrivals if n in departures]
                line.send((way, [(end - encoded, end - begin) for end, begin, encoded in taken]))
    receiver.send(None)
    line.send(len(body))
    for sender in senders.values():
        sender.close()


def _receive(_: Connection, place: Place, sender: Connection) -> None:
    """Receiving process: waits for one way after the other, as the sender announces them."""
    server_key = load_keys(place.remote_keys).public
    curve = BareCurve(place.bare_address(0), zmq.SUB, load_keys(place.operator_keys), server_key)
    receivers: dict[str, Receiver] = {
        LINK: link_receiver(place),
        BUSY_CURVE: bare_receiver(curve, next_touch(touch_parts(), 0, 0).encode()),
        CURVE: bare_receiver(curve),
        TCP: bare_receiver(_connect(place)),
    }
    while (turn := sender.recv()) is not None:
        way, last = turn
        sender.send("ready")
        arrivals: list[Arrival] = []
        while not arrivals or arrivals[-1][0] < last:
            arrival = receivers[way].receive(_GIVE_UP_S)
            if arrival is None:
                break
            arrivals.append(arrival)
        sender.send(arrivals)
    for receiver in receivers.values():
        receiver.close()


def _connect(place: Place) -> PlainTcp:
    for _ in range(_TRIES):
        try:
            return PlainTcp.connect(place.host, place.bare_port(1))
        except ConnectionRefusedError:
            time.sleep(0.1)
    raise EndLost("the sending process does not serve")


def measure(rounds: int, seed: int, progress: Callable[[float], object] = lambda _: None) -> dict[str, Any]:
    """Measure `rounds` blocks of each way; returns the size of a message, and the `summary` of the times.

    Args:
        rounds: blocks of 50 messages of each way; one takes 0.4 s for all four.
        seed: seed of the order of the ways.
        progress: called with the share done, 0..1.

    Raises:
        EndLost: a process ended, or nothing arrives.
    """
    blocks: dict[str, list[list[int]]] = {way: [] for way in (LINK, WITH_ENCODING, *WAYS[1:])}
    one_end, other_end = pipe()
    with TemporaryDirectory(prefix="link-") as folder:
        place = Place.prepare(Path(folder))
        sending = ("sender", _send, (place, one_end, seed, rounds))
        with ends(sending, ("receiver", _receive, (place, other_end))) as (sender, _):
            one_end.close()
            other_end.close()
            for number in range(rounds * len(WAYS)):
                way, taken = sender.receive()
                blocks[way].append([encoded_to_checked_ns for encoded_to_checked_ns, _ in taken])
                if way == LINK:
                    blocks[WITH_ENCODING].append([with_encoding_ns for _, with_encoding_ns in taken])
                progress((number + 1) / (rounds * len(WAYS)))
            size = int(sender.receive())
    return {"message_bytes": size, "rate_hz": STREAMS["touch"].rate_hz, "events": USUAL_EVENTS, **summary(blocks)}


def summary(blocks: Mapping[str, Sequence[Sequence[int]]]) -> dict[str, Any]:
    """Quantiles of each way, us, their ratios to the bare CurveZMQ pairs, and the spread of the ratio to the idle pair.

    Args:
        blocks: one-way times of each block of each way, ns; blocks of one index belong to one round.
    """
    us = {way: np.concatenate([np.asarray(block) for block in of_way]) * 1e-3 for way, of_way in blocks.items()}
    medians = {way: np.array([np.median(block) for block in of_way]) for way, of_way in blocks.items()}
    rows = []
    for way, times in us.items():
        median, p90, p99 = (round(float(value), 2) for value in np.quantile(times, (0.5, 0.9, 0.99)))
        varies = [round(float(v), 3) for v in np.quantile(medians[way] / medians[CURVE], (0.1, 0.5, 0.9))]
        rows.append(
            {
                "way": way,
                "count": len(times),
                "median_us": median,
                "p90_us": p90,
                "p99_us": p99,
                "to_bare": round(float(np.median(times) / np.median(us[CURVE])), 3),
                "to_busy": round(float(np.median(times) / np.median(us[BUSY_CURVE])), 3),
                "to_bare_in_rounds_p10": varies[0],
                "to_bare_in_rounds_p50": varies[1],
                "to_bare_in_rounds_p90": varies[2],
            }
        )
    curves = {way: [round(float(v), 2) for v in np.quantile(times, GRID)] for way, times in us.items()}
    return {"ways": rows, "quantiles": [float(q) for q in GRID], "one_way_us": curves}
