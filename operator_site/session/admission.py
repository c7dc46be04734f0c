"""Reports that the remote site refuses this side's key, and asks again each second until it is admitted.

A refusal never ends a process: any host that answers at the remote site's address can send one.
"""

import logging

from common.link.keys import Role
from common.link.link import OperatorLink
from operator_site.session.session_client import SessionClient

log = logging.getLogger(__name__)

_TRUST = {Role.PARTNER: ("an operator's", ""), Role.OBSERVER: ("an observer's", "--observer ")}


class Admission:
    """Checks the results of the handshakes of one link."""

    def __init__(self, client: SessionClient, link: OperatorLink, remote: str, role: Role = Role.PARTNER):
        """Begin before the first handshake.

        Args:
            client: has the session and publishes the refusal.
            link: detects refusals.
            remote: readable address of the remote site.
            role: role of the key that the remote site has to trust.
        """
        self._client, self._link = client, link
        whose, option = _TRUST[role]
        self._problem = (
            f"{remote}: the remote site does not trust this site's key as {whose}; "
            f"there: `teletaction keys trust {option}--keys FOLDER -- NAME KEY`"
        )
        self._reported = False

    def each_second(self) -> None:
        """Report a refusal once and connect again, because the library does not; withdraw the report in a session."""
        client = self._client
        if self._link.key_refused():
            if not self._reported:
                self._reported = True
                log.warning("%s; asking again each second", self._problem)
            client.refusal = self._problem
            self._link.reconnect()
        elif self._reported and client.session.ident != 0:
            self._reported, client.refusal = False, ""
            log.info("the remote site trusts this site's key now")
