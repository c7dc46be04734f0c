"""Reads the state of the remote site's recording from its answer to a status request."""

from collections.abc import Mapping

from common.files.printable import one_line
from common.wire.packets import BadPacket
from common.wire.session_messages import LONGEST_REFUSAL


def recording_stopped(details: Mapping[str, object]) -> str:
    """Return why the remote site's recording stopped, in one printable line; empty while it works or if unreported.

    Raises:
        BadPacket: the reason is no text.
    """
    said = details.get("recording", "")
    if not isinstance(said, str):
        raise BadPacket("recording is no text")
    return one_line(said, LONGEST_REFUSAL).strip() or ("the remote site does not say why" if said else "")
