"""Reads from the remote site's status file whose session it is, because only that operator may talk."""

from pathlib import Path

from common.health import NoStatus, read_status, young
from common.link.keys import fingerprint
from common.link.session_display import ENDED


class SessionHolder:
    """The operator of the session as of the last `look`.

    Where it is not known, every operator may talk: the patient must be heard and spoken to also while touch is down.
    """

    def __init__(self, status: Path | None) -> None:
        """Read this status file of the remote site; None for no file."""
        self._status = status
        self.fingerprint = ""
        """Fingerprint of the operator's key; empty without a session, or while the file is missing or old."""

    def look(self, now_ns: int) -> None:
        """Read the file; call it once a second."""
        self.fingerprint = ""
        if self._status is None:
            return
        try:
            content, age_s = read_status(self._status, now_ns)
        except NoStatus:
            return
        if young(age_s) and content.get("state") != ENDED:
            self.fingerprint = str(content.get("operator") or "")

    def admits(self, key: str) -> bool:
        """Return whether no other key holds the session."""
        return not self.fingerprint or fingerprint(key) == self.fingerprint
