"""What a person at the patient's side may ask for."""

from typing import Any

from common.link.session_state import Refused
from common.site_status import desk_answer
from remote_site.session.session_server import SessionServer


def answer_desk(
    server: SessionServer, now_ns: int, not_ready: str, verb: str, details: dict[str, Any]
) -> dict[str, Any]:
    """Carry out what was asked; returns how the session is then.

    Args:
        server: this site's end of the session.
        now_ns: this site's clock.
        not_ready: the gate's fault, or else what is missing; empty when the site may engage.
        verb: what is asked for.
        details: what goes with it; nothing here needs any.

    Raises:
        Refused: it cannot be done now, or not here.
    """
    match verb:
        case "status":
            pass
        case "disengage":
            server.session.disengage("asked for at the remote site")
        case "estop":
            server.stop(now_ns, here=True)
        case "clear_fault":
            server.session.clear()
        case _:
            raise Refused(f"{verb} is for the operator's site to ask")
    return desk_answer(verb, server, not_ready)
