"""Carries out the requests of a person at the remote site."""

from collections.abc import Callable
from typing import Any

from common.link.session_state import Refused
from common.site_status import desk_answer
from remote_site.session.session_server import SessionServer


def answer_desk(
    server: SessionServer,
    now_ns: int,
    not_ready: str,
    verb: str,
    *,
    held: bool = False,
    restore_force: Callable[[], None] | None = None,
) -> dict[str, Any]:
    """Carry out a request; return the state of the session afterwards.

    Args:
        server: this site's end of the session.
        now_ns: this site's clock, ns.
        not_ready: the gate's fault, or the missing device; empty when the site may engage.
        verb: verb of the request.
        held: whether the patient presses the stop switch now.
        restore_force: ends the force limit that follows the patient; None unless the pain slider is at 0.

    Raises:
        Refused: the request is not allowed now, or not at this site.
    """
    match verb:
        case "status":
            pass
        case "disengage":
            server.disengage(now_ns)
        case "estop":
            server.stop(now_ns, here=True)
        case "clear_fault":
            if held:
                raise Refused("the patient still presses the stop switch: it has to be released first")
            server.clear(now_ns)
        case "restore_force":
            if restore_force is None:
                raise Refused("the patient reports pain, or no answer is known: the slider has to be at 0 first")
            restore_force()
        case "mute_voice" | "unmute_voice":
            raise Refused(f"{verb} is for the voice's process: teletaction session {verb.replace('_', '-')}")
        case _:
            raise Refused("only the operator site can do this: give its --config")
    return desk_answer(verb, server, not_ready) | server.patient()
