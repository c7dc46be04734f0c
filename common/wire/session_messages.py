"""Messages for clock comparison, requests and their answers."""

import sys
from typing import Annotated, Self

from msgspec import Meta

from common.wire.packets import MAX_INTEGER, BadPacket, Integer, LinkState, Packet

LONGEST_REFUSAL = 400
"""Maximum length of an answer's reason, characters."""
ASKED_BEFORE = "asked before the remote site disengaged: engage again"
"""Refusal of a request to engage that was sent before a person at the remote site disengaged or cleared a fault."""
DESK_REQUESTS = ("attend", "clutch", "scale")
"""Requests that only the local control of the operator site takes."""
REMOTE_DESK_REQUESTS = ("restore_force", "mute_voice", "unmute_voice")
"""Requests that only a local control at the remote site takes: the site's, or the voice's."""
REQUESTS = (
    *("hello", "status", "engage", "disengage", "estop", "clear_fault", "annotate"),
    *(*DESK_REQUESTS, *REMOTE_DESK_REQUESTS, "goodbye"),
)
_Plain = None | bool | int | Annotated[float, Meta(ge=-sys.float_info.max, le=sys.float_info.max)] | str
Details = dict[str, _Plain | list[_Plain]]
"""A flat map of null, booleans, finite numbers, texts, or lists of these."""


class Heartbeat(Packet, frozen=True):
    """One leg of the clock comparison, sent from the loop itself.

    The operator sends `sent_ns`. The remote answers with it, with its own arrival time `arrived_ns`, and with `time_ns`
    as the time of the answer. `offset_ns` +- `uncertainty_ns` is the operator's present estimate of (remote clock -
    operator clock), ns; an uncertainty of 0 means that there is none.
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
    """The answer to the request of the same sequence number; `refused` is empty when the request was done."""

    refused: Annotated[str, Meta(max_length=LONGEST_REFUSAL)]
    details: Details
