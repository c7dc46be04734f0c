"""Reports that one side does not accept the other's key, and asks again each second until this one is admitted.

A refusal never ends a process: any host that answers at the remote site's address can send one.
"""

import logging

from common.link.keys import Role, fingerprint
from common.link.link import OperatorLink
from operator_site.session.session_client import SessionClient

log = logging.getLogger(__name__)

_UNPROVEN = 50
"""Number of failed handshakes in a row that are reported. Some 5 s: a remote site starts behind a proxy in less."""
_TRUST = {Role.PARTNER: ("an operator's", ""), Role.OBSERVER: ("an observer's", "--observer ")}


class Admission:
    """Checks the results of the handshakes of one link."""

    def __init__(self, client: SessionClient, link: OperatorLink, remote: str, role: Role = Role.PARTNER):
        """Begin before the first handshake.

        Args:
            client: has the session and publishes the refusal.
            link: detects refusals, and servers of another key.
            remote: readable address of the remote site.
            role: role of the key that the remote site has to trust.
        """
        self._client, self._link = client, link
        whose, option = _TRUST[role]
        self._untrusted = (
            f"{remote}: the remote site does not trust this site's key as {whose}; "
            f"there: `teletaction keys trust {option}--keys FOLDER -- NAME KEY`"
        )
        self._unproven = (
            f"{remote}: what answers there does not prove the remote site's key {fingerprint(link.remote_key)}: "
            "compare it with `teletaction keys show` there; behind a tunnel, see that the remote site runs"
        )
        self._reported = ""

    def each_second(self) -> None:
        """Report a refusal once and connect again, because the library does not; withdraw the report in a session."""
        client = self._client
        problem = ""
        if self._link.key_refused():
            problem = self._untrusted
            self._link.reconnect()
        elif self._link.unproven >= _UNPROVEN and client.session.ident == 0:
            problem = self._unproven
        if problem:
            if problem != self._reported:
                log.warning("%s; asking again each second", problem)
            self._reported = client.refusal = problem
        elif self._reported and client.session.ident != 0:
            self._reported, client.refusal = "", ""
            log.info("the remote site trusts this site's key now")
