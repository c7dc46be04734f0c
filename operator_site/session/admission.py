"""Checks whether the remote site admits this site; a refusal ends only a site that was never admitted."""

import logging

from common.link.curve import LinkProblem
from common.link.link import OperatorLink
from operator_site.session.session_client import SessionClient

log = logging.getLogger(__name__)


class Admission:
    """Checks the results of the handshakes, and reconnects a site that was admitted before."""

    def __init__(self, client: SessionClient, link: OperatorLink, remote: str):
        """Begin before the first handshake.

        Args:
            client: has the session and publishes the refusal.
            link: detects refusals.
            remote: readable address of the remote site.
        """
        self._client, self._link = client, link
        self._problem = (
            f"{remote}: the remote site does not trust this site's key as an operator's; "
            "there: `teletaction keys trust --keys FOLDER -- NAME KEY`"
        )
        self._admitted = self._reported = False

    def each_second(self) -> None:
        """Check the results of the handshakes.

        Raises:
            LinkProblem: the remote site does not trust this site's key.
        """
        client = self._client
        connected = client.session.ident != 0
        self._admitted = self._admitted or connected
        if not self._link.key_refused():
            if connected and self._reported:
                self._reported, client.refusal = False, ""
            return
        if not self._admitted:
            raise LinkProblem(self._problem)
        # The key was revoked during operation. The library does not retry after a refusal, so reconnect here.
        if not self._reported:
            self._reported, client.refusal = True, self._problem
            log.warning("%s", self._problem)
        self._link.reconnect()
