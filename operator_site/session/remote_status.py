"""What the remote site says of its recording, in its answer to a status request."""

from collections.abc import Mapping

from common.files.printable import one_line
from common.wire.packets import BadPacket
from common.wire.session_messages import LONGEST_REFUSAL


def recording_stopped(details: Mapping[str, object]) -> str:
    """Why the remote site's recording stopped, one printable line; empty while it is well, or where it does not say.

    Raises:
        BadPacket: it is no text.
    """
    said = details.get("recording", "")
    if not isinstance(said, str):
        raise BadPacket("recording is no text")
    return one_line(said, LONGEST_REFUSAL).strip() or ("the remote site does not say why" if said else "")
