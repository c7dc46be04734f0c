"""What the remote site says of its recording, in its answer to a status request."""

from collections.abc import Mapping

from common.packets import BadPacket
from common.session_messages import LONGEST_REFUSAL


def recording_stopped(details: Mapping[str, object]) -> str:
    """Why the remote site's recording stopped, one printable line; empty while it is well, or where it does not say.

    Raises:
        BadPacket: it is no text.
    """
    said = details.get("recording", "")
    if not isinstance(said, str):
        raise BadPacket("recording is no text")
    line = "".join(character if character.isprintable() else " " for character in said[:LONGEST_REFUSAL]).strip()
    return line or ("the remote site does not say why" if said else "")
