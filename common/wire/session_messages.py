"""How the two sites agree: clock comparison, requests and their answers."""

import sys
from typing import Annotated, Self

from msgspec import Meta

from common.wire.packets import MAX_INTEGER, BadPacket, Integer, LinkState, Packet

LONGEST_REFUSAL = 400
"""Characters of an answer's reason."""
REQUESTS = ("hello", "status", "engage", "disengage", "estop", "clear_fault", "annotate", "attend", "goodbye")
_Plain = None | bool | int | Annotated[float, Meta(ge=-sys.float_info.max, le=sys.float_info.max)] | str
Details = dict[str, _Plain | list[_Plain]]
"""A flat map: null, booleans, finite numbers, texts, or lists of these."""


class Heartbeat(Packet, frozen=True):
    """One leg of the clock comparison, from the loop itself.

    The operator sends `sent_ns`; the remote answers with it, its own arrival time `arrived_ns` and
    `time_ns` as the time of the answer. `offset_ns` +- `uncertainty_ns` is what the operator found so
    far for (remote clock - operator clock); an uncertainty of 0 says nothing was found yet.
    """

    state: LinkState
    sent_ns: Integer
    arrived_ns: Integer
    offset_ns: Annotated[int, Meta(ge=-(2**63), le=MAX_INTEGER)]
    uncertainty_ns: Integer


class Request(Packet, frozen=True):
    """A control request; `details` holds a hello's capabilities or an annotation's text."""

    verb: str
    details: Details

    @classmethod
    def decode(cls, packet: bytes) -> Self:
        """Check and unpack; raises BadPacket."""
        request = super().decode(packet)
        if request.verb not in REQUESTS:
            raise BadPacket(f"unknown request {request.verb[:40]!r}")
        return request


class Answer(Packet, frozen=True):
    """The answer to the request of the same sequence number; `refused` is empty when it was done."""

    refused: Annotated[str, Meta(max_length=LONGEST_REFUSAL)]
    details: Details
