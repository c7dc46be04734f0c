"""Whether the remote site lets this one in: its refusal ends a site that was never let in, and no other."""

import logging

from common.link.curve import LinkProblem
from common.link.link import OperatorLink
from operator_site.session.session_client import SessionClient

log = logging.getLogger(__name__)


class Admission:
    """Looks at what became of the handshakes, and tries again where this site was let in before."""

    def __init__(self, client: SessionClient, link: OperatorLink, remote: str):
        """Look at nothing yet.

        Args:
            client: knows whether there is a session, and tells its refusal.
            link: knows of refusals.
            remote: address of the remote site, for people to read.
        """
        self._client, self._link = client, link
        self._problem = (
            f"{remote}: the remote site does not trust this site's key as an operator's; "
            "there: `teletaction keys trust --keys FOLDER -- NAME KEY`"
        )
        self._welcome = self._said = False

    def each_second(self) -> None:
        """Look at what became of the handshakes.

        Raises:
            LinkProblem: the remote site does not trust this site's key.
        """
        client = self._client
        connected = client.session.ident != 0
        self._welcome = self._welcome or connected
        if not self._link.key_refused():
            if connected and self._said:
                self._said, client.refusal = False, ""
            return
        if not self._welcome:
            raise LinkProblem(self._problem)
        # It was revoked while we worked. The library does not try again after a refusal, so we do.
        if not self._said:
            self._said, client.refusal = True, self._problem
            log.warning("%s", self._problem)
        self._link.reconnect()
