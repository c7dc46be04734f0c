"""Carries out the requests of a person at the operator's site."""

from typing import Any

from common.faults.texts import fault_text
from common.link.session_state import Refused, note_text
from common.site_status import desk_answer
from common.wire.packets import LinkState
from operator_site.coupling.motion_coupling import MotionCoupling
from operator_site.session.console_presence import ConsolePresence
from operator_site.session.remote_status import patient_details
from operator_site.session.session_protocol import SessionProtocol


def answer_desk(
    client: SessionProtocol,
    attendance: ConsolePresence,
    coupling: MotionCoupling,
    now_ns: int,
    not_ready: str,
    verb: str,
    details: dict[str, Any],
) -> dict[str, Any]:
    """Carry out a request; return the state of the session afterwards.

    Args:
        client: this site's end of the session.
        attendance: takes the reports of consoles.
        coupling: takes the requests for clutch and motion scale.
        now_ns: this site's clock, ns.
        not_ready: the gate's fault, or the missing device; empty when the site may engage.
        verb: verb of the request.
        details: its arguments.

    Raises:
        Refused: the request is not allowed now, or not at this site.
    """
    session = client.session
    match verb:
        case "status":
            pass
        case "attend":
            attendance.report(now_ns, details.get("seen") is True)
        case "engage":
            if session.state is LinkState.FAULT or client.remote_fault:
                latched = fault_text(session.fault or client.remote_fault)
                raise Refused(f"a fault is latched ({latched}): clear it first")
            if session.state is LinkState.DISCONNECTED and not client.engages_itself:
                raise Refused("no remote site is connected: engage once it is")
            client.engage()
        case "disengage":
            client.disengage(now_ns)
        case "estop":
            client.stop(now_ns)
        case "clear_fault":
            client.clear(now_ns)
        case "annotate":
            if not session.ident:
                raise Refused("there is no session to note anything in")
            client.annotate(now_ns, note_text(details))
        case "clutch" | "scale":
            coupling.ask(verb, details)
        case _:
            raise Refused("only the remote site can do this: give its --config")
    return {
        **desk_answer(verb, client, not_ready),
        "time_ns": now_ns,
        "remote_fault": client.remote_fault,
        "remote_stale": client.remote_stale,
        "refusal": client.refusal,
        "wanted": client.want_engaged,
        "session": client.session.ident,
        **patient_details(client.remote_patient, client.patient_ns),
    }
