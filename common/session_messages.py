"""How the two sites agree: clock comparison, requests and their answers."""

from dataclasses import dataclass
from typing import Any

from common.packets import (
    SCHEMA_VERSION,
    BadPacket,
    LinkState,
    pack,
    read_details,
    read_integer,
    read_state,
    read_text,
    unpack,
)

LONGEST_REFUSAL = 400
"""Characters of an answer's reason."""


@dataclass(frozen=True, slots=True)
class Heartbeat:
    """One leg of the clock comparison, from the loop itself.

    The operator sends `sent_ns`; the remote answers with it, its own arrival time `arrived_ns` and
    `time_ns` as the time of the answer. `offset_ns` +- `uncertainty_ns` is what the operator found so
    far for (remote clock - operator clock); an uncertainty of 0 says nothing was found yet.
    """

    session: int
    sequence: int
    time_ns: int
    state: LinkState
    sent_ns: int
    arrived_ns: int
    offset_ns: int
    uncertainty_ns: int

    def encode(self) -> bytes:
        """Packet bytes."""
        return pack(
            [
                SCHEMA_VERSION,
                self.session,
                self.sequence,
                self.time_ns,
                int(self.state),
                self.sent_ns,
                self.arrived_ns,
                self.offset_ns,
                self.uncertainty_ns,
            ]
        )

    @classmethod
    def decode(cls, packet: bytes) -> "Heartbeat":
        """Check and unpack; raises BadPacket."""
        _, session, sequence, time_ns, state, sent, arrived, offset, uncertainty = unpack(packet, 9)
        return cls(
            session,
            sequence,
            time_ns,
            read_state(state),
            read_integer(sent, "sent_ns"),
            read_integer(arrived, "arrived_ns"),
            read_integer(offset, "offset_ns", low=-(2**63)),
            read_integer(uncertainty, "uncertainty_ns"),
        )


REQUESTS = ("hello", "status", "engage", "disengage", "estop", "clear_fault", "annotate", "attend", "goodbye")


@dataclass(frozen=True, slots=True)
class Request:
    """A control request; `details` holds a hello's capabilities or an annotation's text."""

    session: int
    sequence: int
    time_ns: int
    verb: str
    details: dict[str, Any]

    def encode(self) -> bytes:
        """Packet bytes."""
        return pack([SCHEMA_VERSION, self.session, self.sequence, self.time_ns, self.verb, self.details])

    @classmethod
    def decode(cls, packet: bytes) -> "Request":
        """Check and unpack; raises BadPacket."""
        _, session, sequence, time_ns, verb, details = unpack(packet, 6)
        if not isinstance(verb, str) or verb not in REQUESTS:
            raise BadPacket(f"unknown request {verb[:40] if isinstance(verb, str) else type(verb).__name__!r}")
        return cls(session, sequence, time_ns, verb, read_details(details))


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer to the request of the same sequence number; `refused` is empty when it was done."""

    session: int
    sequence: int
    time_ns: int
    refused: str
    details: dict[str, Any]

    def encode(self) -> bytes:
        """Packet bytes."""
        return pack([SCHEMA_VERSION, self.session, self.sequence, self.time_ns, self.refused, self.details])

    @classmethod
    def decode(cls, packet: bytes) -> "Answer":
        """Check and unpack; raises BadPacket."""
        _, session, sequence, time_ns, refused, details = unpack(packet, 6)
        return cls(
            session,
            sequence,
            time_ns,
            read_text(refused, "refused", LONGEST_REFUSAL),
            read_details(details),
        )
