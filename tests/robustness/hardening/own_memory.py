"""The resident memory of this process."""

import resource
from pathlib import Path


def own_resident_bytes() -> int:
    """Resident memory without pages of files, programs and libraries: those the system takes and gives as it likes.

    Zero where the system does not report it.
    """
    table = Path("/proc/self/statm")
    resident, of_files = map(int, table.read_text("ascii").split()[1:3]) if table.exists() else (0, 0)
    return (resident - of_files) * resource.getpagesize()
