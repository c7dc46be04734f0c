"""Apply the commands of `sim_sensors.network.live` to a test bed's network."""

from common.wire.streams import Direction
from sim_sensors.network.conditions import Conditions
from sim_sensors.network.fault import WAYS
from sim_sensors.network.file import Network as Timetable
from sim_sensors.network.live import LiveNetwork
from teletaction.testbed.network import TO_OPERATOR, TO_REMOTE, Network

_SHORTEST_S = 0.001
"""One-way delay of a good network, s."""
_NOT_HERE = ("cut", "half_open")
"""Faults of TCP connections, which a network in memory does not have."""


class NetworkFaults:
    """Delay, jitter, stalls and partitions; call `step` in every step of the test bed.

    During a partition TCP retransmits until its end, so packets arrive late, as after a stall.
    """

    def __init__(self, network: Network, timetable: Timetable | None = None) -> None:
        """Start now with a timetable, whose faults of connections are left out; without one, with a good network."""
        self._network = network
        self._live = LiveNetwork(timetable or Timetable("test bed", lambda _: Conditions()))
        self._live.start_s = None if timetable is None else network.now_s

    def obey(self, command: str) -> str:
        """Execute a command of `LiveNetwork.obey`; return a description of its effect.

        Raises:
            ValueError: the command is invalid, or affects TCP connections.
        """
        if command.split()[:1] in [[each] for each in _NOT_HERE]:
            raise ValueError(f"{command}: a network in memory has no connections")
        done = self._live.obey(command, self._network.now_s)
        self.step()
        return done

    def step(self) -> None:
        """Apply the present conditions and outages to the network."""
        now_s = self._network.now_s
        self._live.begin_faults(now_s)
        conditions = self._live.conditions(now_s)
        for way in WAYS:
            path = self._live.paths[way]
            down = path.stalls.end_s(now_s) is not None or path.partitions.end_s(now_s) is not None
            self._network.impair(
                TO_REMOTE if way is Direction.TO_REMOTE else TO_OPERATOR,
                delay_s=max(_SHORTEST_S, conditions.delay_s - conditions.jitter_s),
                jitter_s=2.0 * conditions.jitter_s,
                stalled=down,
            )
