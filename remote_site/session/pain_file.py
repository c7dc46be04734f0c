"""Keeps the force limit that follows the patient in a file, so that a restart of the remote site does not raise it.

The file exists while the limit holds, and has it in N. Any other content stands for the lowest limit, such as none
after a full disk or a power cut.
"""

import logging
from pathlib import Path

from common.files.printable import printable
from common.limits import CONTACT_FORCE_N, PAIN_LEAST_N
from remote_site.session.kept_text import KeptText

log = logging.getLogger(__name__)

SUFFIX = ".pain"
"""The file has the name of the site's status file, with this suffix."""


class PainFile(KeptText):
    """The file of one remote site."""

    def __init__(self, status: Path | None):
        """Keep the limit beside this status file; without one, keep none."""
        super().__init__(None if status is None else status.with_suffix(SUFFIX), "pain file", _would)

    def limit_n(self) -> float | None:
        """Return the limit of an earlier process of this site, N; None without one."""
        content = self.read()
        if content is None:
            return None
        try:
            limit_n = float(content)
        except ValueError:
            limit_n = 0.0
        if not PAIN_LEAST_N <= limit_n <= CONTACT_FORCE_N:
            log.warning("%s is damaged (%s): the lowest force limit holds", self.place, printable(content) or "empty")
            limit_n = PAIN_LEAST_N
        log.warning("force limited to %.1f N before this start, by the patient's threshold", limit_n)
        self.found(content)
        return limit_n

    def keep_limit(self, limit_n: float) -> None:
        """Write the present limit, N, or remove the file where it is none; returns at once."""
        self.keep(repr(float(limit_n)) if limit_n < CONTACT_FORCE_N else None)


def _would(limit: str | None, exists: bool) -> str:
    if limit is None:
        return "limit the force again, to the patient's old threshold"
    return "use an older force limit, or the lowest" if exists else "end the force limit by the patient's threshold"
