"""Age of rendered data on a network with delay, jitter and loss: the method's limit, in virtual time.

Touch packets and heartbeats pass through the network model's TCP streams, and through the link's own packet filter and
clock comparison. The simulation runs faster than real time: a second of the session takes some hundredths of one.
"""

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import product
from random import Random
from typing import Any, NamedTuple

import numpy as np

from benchmarks.link.packets import SESSION, framed_bytes, next_touch, touch_parts
from common.limits import AGE_DEFAULT_S, AGE_MAX_S, GAP_S
from common.link.clock_offset import ClockOffset
from common.link.packet_filter import PacketFilter
from common.timing.timeouts import REFRESH_S, SECOND_REFRESH_S
from common.wire.streams import STREAMS
from operator_site.session.second_connections import FAR_NS
from sim_sensors.network.conditions import Conditions
from sim_sensors.network.path import NetworkPath
from sim_sensors.network.stream import TcpStream
from studies.pieces import Piece

AGES_S = (AGE_DEFAULT_S, AGE_MAX_S)
TICK_NS = 2_000_000
"""Tick period of both sites, ns: 500 Hz. The operator's ticks lie midway between the remote's."""
REFRESH_TICKS, SECOND_REFRESH_TICKS = (round(refresh_s * 1e9) // TICK_NS for refresh_s in (REFRESH_S, SECOND_REFRESH_S))
"""Ticks from one touch packet to the next at rest, with a deadband: on one connection, and on two."""
_SETTLE_S = 3.0
_BEAT_TICKS = round(1e9 / TICK_NS / STREAMS["heartbeat"].rate_hz)
_BEAT_BYTES = framed_bytes(60)
_START_NS = 10**12


class Sending(NamedTuple):
    """How touch is sent: ticks from one packet to the next, connections to a far site, and ticks on more than one."""

    every: int = 1
    connections: int = 1
    far_every: int = 1


_SIMPLE = Sending()
SHIPPED, ONE_CONNECTION, EVERY_TICK = "as shipped", "one connection", "without a deadband"
SENT = {
    SHIPPED: Sending(REFRESH_TICKS, 2, SECOND_REFRESH_TICKS),
    ONE_CONNECTION: Sending(REFRESH_TICKS, 1),
    EVERY_TICK: Sending(1, 2),
}


class Packet(NamedTuple):
    """The fields of a packet that acceptance checks."""

    session: int
    sequence: int
    time_ns: int


@dataclass(slots=True)
class MessageStream:
    """Messages of one length over a TCP stream; each arrives with its last byte."""

    stream: TcpStream
    size: int
    _under_way: deque[Any] = field(default_factory=deque)
    _unread: int = 0

    def send(self, message: object, now_ns: int) -> None:
        """Send a message."""
        self._under_way.append(message)
        self.stream.push(bytes(self.size), now_ns * 1e-9)

    def receive(self, now_ns: int) -> list[Any]:
        """Messages that have arrived whole by now."""
        self._unread += len(self.stream.take(now_ns * 1e-9))
        count, self._unread = divmod(self._unread, self.size)
        return [self._under_way.popleft() for _ in range(count)]


@dataclass(slots=True)
class Age:
    """Age of the newest accepted packet at each of the operator's ticks, for one age limit."""

    acceptance: PacketFilter
    newest_ns: int | None = None
    ages_ns: list[int] = field(default_factory=list)
    ticks: int = 0
    silent_ticks: int = 0

    def tick(self, packets: Iterable[Packet], now_ns: int, clock: ClockOffset, count: bool) -> None:
        """Judge the newest packet of each connection; count the tick if `count` is set."""
        for newest in packets:
            if self.acceptance.accept(newest, SESSION, now_ns, clock.offset_ns, clock.uncertainty_ns):
                self.newest_ns = newest.time_ns
        if not count:
            return
        self.ticks += 1
        gap_ns = self.acceptance.gap_ns(now_ns)
        if gap_ns is None or gap_ns > GAP_S * 1e9:
            self.silent_ticks += 1
        if self.newest_ns is not None:
            self.ages_ns.append(now_ns - self.newest_ns)


def ages(conditions: Conditions, seconds: float, seed: int, sending: Sending = _SIMPLE) -> list[dict[str, Any]]:
    """Simulate `seconds` on a network of these conditions, for each age limit.

    Args:
        conditions: conditions in both directions.
        seconds: counted time, s.
        seed: seed of jitter and losses.
        sending: how touch is sent.

    Returns:
        For each limit: median and 99th percentile of the age of the newest accepted packet at every tick, ms, and the
            share of ticks in the safe state, 0..1. Ages are None where no packet was accepted. The safe state is a tick
            without an accepted packet for longer than the gap.
    """
    chance = Random(seed)

    def stream(path: NetworkPath, size: int) -> MessageStream:
        return MessageStream(TcpStream(path, Random(chance.random())), size)

    to_operator, to_remote = NetworkPath(lambda _: conditions), NetworkPath(lambda _: conditions)
    touch_bytes = framed_bytes(len(next_touch(touch_parts(), 10_000, _START_NS).encode()))
    touches = [stream(to_operator, touch_bytes)]
    beats, answers = stream(to_remote, _BEAT_BYTES), stream(to_operator, _BEAT_BYTES)
    every = sending.every
    if sending.connections > 1 and conditions.loss > 0.0 and 2e9 * conditions.delay_s > FAR_NS:
        every = sending.far_every
        touches += [stream(to_operator, touch_bytes) for _ in range(1, sending.connections)]
    clock, found = ClockOffset(), [Age(PacketFilter(round(limit_s * 1e9))) for limit_s in AGES_S]
    for tick in range(round((_SETTLE_S + seconds) * 1e9) // TICK_NS):
        remote_ns = tick * TICK_NS
        operator_ns = remote_ns + TICK_NS // 2
        if tick % every == 0:
            for touch in touches:
                touch.send(Packet(SESSION, tick + 1, remote_ns), remote_ns)
        for sent_ns in beats.receive(remote_ns):
            answers.send((sent_ns, remote_ns), remote_ns)
        for sent_ns, answered_ns in answers.receive(operator_ns):
            clock.add(sent_ns, answered_ns, answered_ns, operator_ns)
        if tick % _BEAT_TICKS == 0:
            beats.send(operator_ns, operator_ns)
        packets = [packet for touch in touches for packet in touch.receive(operator_ns)[-1:]]
        for age in found:
            age.tick(packets, operator_ns, clock, count=remote_ns >= _SETTLE_S * 1e9)
    return [_row(limit_s, age) for limit_s, age in zip(AGES_S, found, strict=True)]


def _row(limit_s: float, age: Age) -> dict[str, Any]:
    median_ms, p99_ms = (None, None) if not age.ages_ns else np.quantile(age.ages_ns, (0.5, 0.99)) * 1e-6
    return {
        "max_age_ms": round(limit_s * 1e3),
        "age_median_ms": None if median_ms is None else round(float(median_ms), 2),
        "age_p99_ms": None if p99_ms is None else round(float(p99_ms), 2),
        "safe_state_share": round(age.silent_ticks / age.ticks, 5),
    }


def grid(quick: bool) -> list[Conditions]:
    """Delays 0-400 ms, jitter 0-40 ms (at most the delay), loss 0-10 %."""
    delays_ms = (0, 50, 100, 150, 200, 400) if quick else (0, 10, 25, 50, 75, 100, 125, 140, 150, 175, 200, 300, 400)
    jitters_ms = (0, 20) if quick else (0, 10, 20, 40)
    losses = (0.0, 0.01, 0.1) if quick else (0.0, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1)
    return [
        Conditions(delay_s=delay_ms * 1e-3, jitter_s=jitter_ms * 1e-3, loss=loss)
        for delay_ms, jitter_ms, loss in product(delays_ms, jitters_ms, losses)
        if jitter_ms <= delay_ms
    ]


def sweep(quick: bool, seed: int) -> list[Piece]:
    """A piece for each network of `grid` and way of sending, with a row for each age limit."""
    seconds = 5.0 if quick else 20.0
    networks = enumerate(grid(quick), start=seed)
    return [(_on, (network, sent, seconds, number)) for number, network in networks for sent in SENT]


def _on(network: Conditions, sent: str, seconds: float, seed: int) -> list[dict[str, Any]]:
    where = {
        "sent": sent,
        "delay_ms": round(network.delay_s * 1e3),
        "jitter_ms": round(network.jitter_s * 1e3),
        "loss_percent": round(network.loss * 1e2, 3),
    }
    return [{**where, **row} for row in ages(network, seconds, seed, SENT[sent])]
