"""Finds free ports for the processes of a session on this machine."""

import os
import socket
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from itertools import count, islice
from typing import Self

from common.fingers import FingerName
from common.wire.streams import STREAMS

HOST = "127.0.0.1"
SINGLE = 12
"""Number of ports that are neither of a stream nor of a finger."""


@dataclass(frozen=True, slots=True)
class DemoPorts:
    """Ports of a session; those of serial devices by finger.

    Attributes:
        link: first port of the remote site's streams.
        through: first port of the same streams at the simulated network, which connects to `link`.
        texture, thermal, tacttip: serial devices.
        robot, exoskeleton: CAN gateways.
        patient_switch, camera: devices beside the patient.
        remote_faults, operator_faults, network_faults: commands that inject faults.
        remote_desk, operator_desk, voice_desk: local control.
        feed: what the operator site sends to the console.
        page: the console's page.
    """

    link: int
    through: int
    texture: dict[FingerName, int]
    thermal: dict[FingerName, int]
    tacttip: dict[FingerName, int]
    robot: int
    exoskeleton: int
    patient_switch: int
    camera: int
    remote_faults: int
    operator_faults: int
    network_faults: int
    remote_desk: int
    operator_desk: int
    voice_desk: int
    feed: int
    page: int

    @classmethod
    def free(cls, fingers: Sequence[FingerName]) -> Self:
        """Return ports that nothing listens on; raises OSError where there are not enough."""
        streams = 2 * len(STREAMS)
        first = free_port_block(streams + 3 * len(fingers) + SINGLE)
        ports = count(first + streams)
        texture, thermal, tacttip = ({finger: next(ports) for finger in fingers} for _ in range(3))
        return cls(first, first + len(STREAMS), texture, thermal, tacttip, *islice(ports, SINGLE))


def free_port_block(length: int) -> int:
    """Return the first of `length` consecutive free ports, below the range of outgoing connections.

    Raises:
        OSError: no such block was found.
    """
    firsts = range(20_000, 32_000, length)
    # The start depends on the process, so that sessions prepared at the same time take different blocks.
    turn = os.getpid() % len(firsts)
    for number in range(len(firsts)):
        first = firsts[(turn + number) % len(firsts)]
        with ExitStack() as held:
            try:
                for n in range(length):
                    held.enter_context(socket.create_server((HOST, first + n)))
            except OSError:
                continue
            return first
    raise OSError(f"no {length} consecutive free ports on {HOST}")
