"""Keeps a person's latched stop in a file, so that a restart of the remote site does not clear it.

The file exists while the stop is latched, and holds its code. Any other content is a stop, too, such as none after a
full disk or a power cut.
"""

import logging
from pathlib import Path

from common.faults.fault import PERSONS_STOPS, Fault, FaultCode
from common.files.printable import printable
from remote_site.session.kept_text import KeptText

log = logging.getLogger(__name__)

SUFFIX = ".stop"
"""The file has the name of the site's status file, with this suffix."""


class StopFile(KeptText):
    """The file of one remote site."""

    def __init__(self, status: Path | None):
        """Keep stops beside this status file; without one, keep none."""
        super().__init__(None if status is None else status.with_suffix(SUFFIX), "stop file", _would)

    def latched(self) -> Fault | None:
        """Return the stop that an earlier process of this site has latched; None without one."""
        content = self.read()
        if content is None:
            return None
        log.warning("a stop was latched before this start (%s): %s", self.place, printable(content) or "damaged")
        found = next((code for code in PERSONS_STOPS if code == content), FaultCode.UNKNOWN)
        self.found(found)
        return Fault(found, detail=f"in {self.place}" if found is FaultCode.UNKNOWN else "")


def _would(stop: str | None, exists: bool) -> str:
    if stop is None:
        return "latch the cleared stop again"
    return "keep the latched stop without its cause" if exists else "clear a latched stop"
