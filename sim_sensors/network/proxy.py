"""Simulate the network between two sites: accept the operator's connections and forward them to the remote site.

The operating system completes a client's TCP handshake by itself. During a partition, the proxy does not connect the
client to the far side, so a new connection receives no first byte.
"""

import logging
import socket
from collections.abc import Callable
from contextlib import ExitStack, closing
from random import Random

from common.config.simulation_models import SimNetworkConfig
from common.runtime.periodic_loop import PeriodicLoop
from common.runtime.scheduling import become_timely
from common.runtime.status_file import StatusFile
from common.wire.streams import STREAMS, Stream
from sim_sensors.faults.fault_port import FaultPort
from sim_sensors.network.connection import BUFFER_BYTES, Connection
from sim_sensors.network.fault import WAYS, Fault
from sim_sensors.network.file import load_network
from sim_sensors.network.live import LiveNetwork
from sim_sensors.network.stream import Carried, TcpStream
from sim_sensors.ports.select_loop import SelectLoop
from sim_sensors.ports.tcp_port import TcpPort

log = logging.getLogger(__name__)

TICK_S = 0.001


class StreamProxy:
    """All connections of one stream of the link, past and present."""

    def __init__(self, stream: Stream, config: SimNetworkConfig, live: LiveNetwork, sockets: SelectLoop) -> None:
        """Listen; raises ValueError where the address is taken or is not this machine's."""
        self.connections: list[Connection] = []
        self._name = stream.name
        self._to = (config.to_host, config.to_base_port + stream.port)
        self._seed = config.seed
        self._live = live
        self._sockets = sockets
        self._made = 0
        self._carried = {way: Carried() for way in WAYS}
        self._port = TcpPort(
            sockets,
            config.bind,
            config.base_port + stream.port,
            f"network, {stream.name}",
            buffer_bytes=BUFFER_BYTES,
            greet=self._greet,
        )

    def step(self, now_s: float) -> None:
        """Connect waiting clients unless the network is partitioned, and move bytes."""
        reachable = not self._live.partitioned(now_s)
        for connection in self.connections:
            if reachable:
                connection.connect(*self._to)
            connection.step(now_s)
        self._forget_closed()

    def begin_fault(self, fault: Fault, begin_s: float) -> None:
        """Apply a fault to all present connections."""
        for connection in self.connections:
            connection.begin_fault(fault, begin_s)
        self._forget_closed()

    def figures(self) -> dict[str, object]:
        """Return the number of connections, and the traffic so far by direction."""
        figures: dict[str, object] = {"connections_made": self._made, "connections_open": len(self.connections)}
        for way in WAYS:
            carried = self._carried[way]
            figures[way.name.lower()] = {
                "bytes": carried.bytes,
                "retransmitted": carried.retransmitted,
                "longest_ms": round(1e3 * carried.longest_s, 3),
                "in_flight_bytes": sum(connection.streams[way].in_flight for connection in self.connections),
            }
        return figures

    def close(self) -> None:
        """Reset all connections and release the port."""
        for connection in self.connections:
            connection.reset()
        self._forget_closed()
        self._port.close()

    def _greet(self, client: socket.socket, now_s: float) -> None:
        client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER_BYTES)
        self._made += 1
        chances = {way: Random(f"{self._seed} {self._name} {way.name} {self._made}") for way in WAYS}
        streams = {way: TcpStream(self._live.paths[way], chances[way], self._carried[way]) for way in WAYS}
        self.connections.append(Connection(client, streams, self._sockets))

    def _forget_closed(self) -> None:
        self.connections = [connection for connection in self.connections if not connection.closed]


class NetworkProxy:
    """The network of a session, for all of its streams."""

    def __init__(self, config: SimNetworkConfig, sockets: SelectLoop) -> None:
        """Open all ports; raises ValueError where the network is unknown or its file is bad, or a port is taken."""
        network = load_network(config.network)
        self._sockets = sockets
        self.live = LiveNetwork(network, None if config.wait_for_start else sockets.now())
        with ExitStack() as opened:
            self._streams: dict[str, StreamProxy] = {}
            for name, stream in STREAMS.items():
                self._streams[name] = StreamProxy(stream, config, self.live, sockets)
                opened.callback(self._streams[name].close)
            if config.fault_port is not None:
                opened.enter_context(closing(FaultPort(sockets, config.fault_port, self.obey)))
            self._opened = opened.pop_all()

    def step(self, now_s: float) -> None:
        """Begin the due faults, then advance all streams to `now_s`."""
        for begin_s, fault in self.live.begin_faults(now_s):
            log.info("%s", fault.model_dump_json(exclude_none=True, exclude={"at_s"}))
            for stream in self._streams.values():
                stream.begin_fault(fault, begin_s)
        for stream in self._streams.values():
            stream.step(now_s)

    def figures(self) -> dict[str, object]:
        """Return the content of the status file: the network, its present conditions, streams and past faults."""
        now_s = self._sockets.now()
        conditions = self.live.conditions(now_s)
        return {
            "network": self.live.network.name,
            "started": self.live.start_s is not None,
            "network_s": round(self.live.time_s(now_s), 3),
            "delay_ms": round(1e3 * conditions.delay_s, 3),
            "jitter_ms": round(1e3 * conditions.jitter_s, 3),
            "streams": {name: stream.figures() for name, stream in self._streams.items()},
            "faults": [
                {**fault.model_dump(exclude_none=True), "at_s": round(self.live.time_s(begin_s), 3)}
                for begin_s, fault in self.live.happened
            ],
        }

    def obey(self, command: str) -> str:
        """Execute a command of `LiveNetwork.obey` now, and return a description of its effect."""
        now_s = self._sockets.now()
        self.step(now_s)  # the command takes effect only from now on
        effect = self.live.obey(command, now_s)
        self.step(now_s)
        log.info("command: %s", command)
        return effect

    def close(self) -> None:
        """Reset all connections and release all ports."""
        self._opened.close()


def run_sim_network(config: SimNetworkConfig, stop: Callable[[], bool]) -> None:
    """Run the simulated network between two sites until `stop()`.

    Raises:
        ValueError: the network is unknown or its file is bad, or a port is taken.
    """
    sockets = SelectLoop()
    with closing(NetworkProxy(config, sockets)) as proxy:
        to = config.to_host, config.to_base_port
        log.info("%s: %s:%d to %s:%d", config.network, config.bind, config.base_port, *to)
        become_timely()
        loop = PeriodicLoop(TICK_S, now=sockets.now, sleep=sockets.serve)
        status = StatusFile(config.status, "network", loop)
        for now_s in sockets.ticks(loop, stop):
            proxy.step(now_s)
            if status.due(now_s):
                status.write(now_s, proxy.figures())
        status.write(sockets.now(), proxy.figures())
