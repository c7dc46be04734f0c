"""Processor time of the link: both ends in otherwise empty loops, beside bare sockets in the same loops.

Each measurement starts the ends as new processes. They tick as the sites do, and count the time of all their threads. A
loop without any socket shows the cost of ticking itself.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import zmq

from benchmarks.link.bare import BareCurve
from benchmarks.link.ends import EndLost, Place, cpu_s, ends
from benchmarks.link.packets import SESSION, next_motion, next_touch, touch_parts
from common.limits import AGE_MAX_S
from common.link.keys import Role, TrustedKeys, load_keys
from common.link.link import OperatorLink, RemoteLink
from common.link.packet_filter import PacketFilter
from common.runtime.periodic_loop import PeriodicLoop
from common.wire.messages import Motion, Touch
from operator_site.session.read_only_client import RATE_HZ as OBSERVER_HZ

LINK, CURVE, LOOP = "link", "bare CurveZMQ", "loop alone"
WAYS = (LINK, CURVE, LOOP)
_SETTLE_S = 1.0
"""Time until all ends are connected and warm, s."""


@dataclass(frozen=True, slots=True)
class Load:
    """Traffic between the two ends.

    Attributes:
        way: one of WAYS.
        touch_hz, motion_hz: packets a second; one is a multiple of the other.
        touching: fingers in contact, 0..5.
        observers: number of read-only clients, each a process of its own.
    """

    way: str = LINK
    touch_hz: float = 500.0
    motion_hz: float = 1000.0
    touching: int = 5
    observers: int = 0

    @property
    def loop_hz(self) -> float:
        """Rate of both loops."""
        return max(self.touch_hz, self.motion_hz)


class _End(NamedTuple):
    """One end, called in each tick: sends a numbered packet, and receives one; a loop alone does nothing."""

    send: Callable[[int], object] = lambda _: None
    receive: Callable[[], bool] = lambda: False
    close: Callable[[], None] = lambda: None


def _link_remote(place: Place, load: Load) -> _End:
    link = RemoteLink(place.host, place.base_port, load_keys(place.remote_keys), TrustedKeys(place.remote_keys))
    like = touch_parts(load.touching)
    streams = ("touch", "observed") if load.observers else ("touch",)

    def send(sequence: int) -> None:
        packet = next_touch(like, sequence, time.monotonic_ns()).encode()
        for stream in streams:
            link.send_latest(stream, packet)

    return _End(send, _accepted(lambda: link.receive_latest("motion"), Motion), link.close)


def _link_client(place: Place, role: Role) -> _End:
    """Return the end of an operator, or of a read-only client that sends nothing."""
    partner = role is Role.PARTNER
    keys = load_keys(place.operator_keys if partner else place.observer_keys)
    link = OperatorLink(place.host, place.base_port, keys, load_keys(place.remote_keys).public, role)
    stream = "touch" if partner else "observed"

    def send(sequence: int) -> None:
        link.send_latest("motion", next_motion(sequence, time.monotonic_ns()))

    return _End(send, _accepted(lambda: link.receive_latest(stream), Touch), link.close)


def _accepted(receive: Callable[[], bytes | None], kind: type[Motion | Touch]) -> Callable[[], bool]:
    """Return a function that receives a packet and returns whether there is one that a site accepts."""
    acceptance = PacketFilter(round(AGE_MAX_S * 1e9))

    def received() -> bool:
        packet = receive()
        return packet is not None and acceptance.accept(kind.decode(packet), SESSION, time.monotonic_ns(), 0, 0)

    return received


def _bare_end(place: Place, load: Load, remote: bool) -> _End:
    server, client = load_keys(place.remote_keys), load_keys(place.operator_keys)
    touches, motions = place.bare_address(0), place.bare_address(1)
    if remote:
        message = next_touch(touch_parts(load.touching), 10_000, 10**15).encode()
        outgoing, incoming = BareCurve(touches, zmq.PUB, server), BareCurve(motions, zmq.PULL, server)
    else:
        message = next_motion(10_000, 10**15)
        outgoing = BareCurve(motions, zmq.PUSH, client, server.public)
        incoming = BareCurve(touches, zmq.SUB, client, server.public)

    def close() -> None:
        outgoing.close()
        incoming.close()

    return _End(lambda _: outgoing.send(message), lambda: incoming.receive_now() is not None, close)


def _run_site(line: Connection, place: Place, load: Load, seconds: float, remote: bool) -> None:
    end = _End()
    if load.way == LINK:
        end = _link_remote(place, load) if remote else _link_client(place, Role.PARTNER)
    elif load.way == CURVE:
        end = _bare_end(place, load, remote)
    _run(line, end, load.loop_hz, round(load.loop_hz / (load.touch_hz if remote else load.motion_hz)), seconds)


def _run_observer(line: Connection, place: Place, seconds: float) -> None:
    _run(line, _link_client(place, Role.OBSERVER), OBSERVER_HZ, 0, seconds)


def _run(line: Connection, end: _End, loop_hz: float, send_every: int, seconds: float) -> None:
    """Tick, send every `send_every` ticks (0: never), receive, and report the cost of `seconds`."""
    line.send("ready")
    line.recv()
    loop = PeriodicLoop(1.0 / loop_hz)
    settle, last = round(_SETTLE_S * loop_hz), round((_SETTLE_S + seconds) * loop_hz)
    sent = received = 0
    begin_s = begin_cpu_s = 0.0
    for tick in range(last):
        if tick == settle:
            sent = received = 0
            begin_s, begin_cpu_s = time.monotonic(), cpu_s()
        loop.wait()
        if send_every and tick % send_every == 0:
            sent += 1
            end.send(tick + 1)
        received += end.receive()
    used_s, took_s = cpu_s() - begin_cpu_s, time.monotonic() - begin_s
    # The work is that of `seconds` at full rate, also where a busy machine makes the loop late.
    line.send({"cpu": used_s / seconds, "sent_hz": sent / took_s, "received_hz": received / took_s})
    end.close()


def measure(load: Load, seconds: float) -> dict[str, Any]:
    """Run both ends, and observers, for `seconds`; returns processor shares (1 is a whole core) and rates.

    Raises:
        EndLost: an end ended, or received nothing.
    """
    with TemporaryDirectory(prefix="link-") as folder:
        place = Place.prepare(Path(folder))
        observers = [("observer", _run_observer, (place, seconds)) for _ in range(load.observers)]
        with ends(
            ("remote", _run_site, (place, load, seconds, True)),
            ("operator", _run_site, (place, load, seconds, False)),
            *observers,
        ) as running:
            for end in running:
                end.receive()
            for end in running:
                end.line.send("go")
            found = [end.receive(_SETTLE_S + seconds) for end in running]
    remote, operator, *others = found
    if load.way != LOOP and not all(each["received_hz"] for each in found):
        raise EndLost(f"{load}: an end received nothing")
    return {
        **asdict(load),
        "remote_cpu": round(remote["cpu"], 5),
        "operator_cpu": round(operator["cpu"], 5),
        "observers_cpu": round(sum(other["cpu"] for other in others), 5),
        "all_cpu": round(sum(each["cpu"] for each in found), 5),
        "touch_sent_hz": round(remote["sent_hz"], 1),
        "touch_received_hz": round(operator["received_hz"], 1),
        "motion_sent_hz": round(operator["sent_hz"], 1),
        "motion_received_hz": round(remote["received_hz"], 1),
    }


def compare(rounds: int, seconds: float, progress: Callable[[float], object] = lambda _: None) -> list[dict[str, Any]]:
    """Measure the link, bare sockets and the loop alone in turn, `rounds` times each."""
    rows = []
    for number in range(rounds * len(WAYS)):
        rows.append(measure(Load(WAYS[number % len(WAYS)]), seconds))
        progress((number + 1) / (rounds * len(WAYS)))
    return rows


def ratios(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Median share of each way, ratio of link to bare, and this ratio without the cost of the loop alone.

    Args:
        rows: result of `compare`: each way in each round.
    """
    share = {way: [row["all_cpu"] for row in rows if row["way"] == way] for way in WAYS}
    middle = {way: median(shares) for way, shares in share.items()}
    by_round = [link / bare for link, bare in zip(share[LINK], share[CURVE], strict=True)]
    return {
        "all_cpu": middle,
        "link_to_bare": round(median(by_round), 3),
        "link_to_bare_rounds": [round(value, 3) for value in by_round],
        "without_loop": round((middle[LINK] - middle[LOOP]) / max(middle[CURVE] - middle[LOOP], 1e-9), 3),
    }


def scaling_loads(quick: bool) -> list[tuple[str, Load]]:
    """Loads that vary one quantity each: rate, touching fingers, read-only clients."""
    rates = (100.0, 500.0, 1000.0) if quick else (100.0, 200.0, 500.0, 1000.0)
    fingers = (1, 5) if quick else (1, 2, 3, 4, 5)
    observers = (0, 2) if quick else (0, 1, 2, 3, 4, 5)
    return [
        *(("rate", Load(touch_hz=rate, motion_hz=rate)) for rate in rates),
        *(("fingers", Load(touching=count)) for count in fingers),
        *(("observers", Load(observers=count)) for count in observers),
    ]


def scale(quick: bool, seconds: float, progress: Callable[[float], object] = lambda _: None) -> list[dict[str, Any]]:
    """Measure each of `scaling_loads` once."""
    loads, rows = scaling_loads(quick), []
    for number, (varied, load) in enumerate(loads):
        rows.append({"varied": varied, **measure(load, seconds)})
        progress((number + 1) / len(loads))
    return rows
