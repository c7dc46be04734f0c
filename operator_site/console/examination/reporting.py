"""The report of an examination that has ended: written by a command of its own, beside everything else."""

import asyncio
import logging
import os
import re
from collections.abc import Sequence
from itertools import chain
from pathlib import Path

from common.files.unique_path import free_name

log = logging.getLogger(__name__)

SETTLED_S = 1.0
"""So much after the end all that was recorded of it is on the disk."""
LONGEST_S = 300.0
_NICE = 15
PLACE = "{report}"
"""In the command, where the report is to be written."""
RECORD = "{record}"
"""A word of the command: the files that hold what the examination found."""


class Reporting:
    """Runs the configured command, and knows what it has written."""

    def __init__(self, command: Sequence[str], folder: Path | None):
        """Write to `folder`; without a command or a folder there are no reports."""
        self._command, self._folder = list(command), folder

    async def write(self, pseudonym: str, files: Sequence[Path]) -> str:
        """Write the report of an examination; its address at the console's server.

        Args:
            pseudonym: whose it is.
            files: what was found in it.

        Raises:
            OSError: there is none; the message says why.
        """
        if self._folder is None or not self._command:
            raise OSError("no report is configured: report_command and reports")
        self._folder.mkdir(parents=True, exist_ok=True)
        # An earlier examination of the same person keeps its report.
        path = free_name(self._folder / (re.sub(r"[^\w-]", "_", pseudonym) + ".html"))
        await asyncio.sleep(SETTLED_S)
        words = [[*map(str, files)] if word == RECORD else [word.replace(PLACE, str(path))] for word in self._command]
        process = await asyncio.create_subprocess_exec(
            *chain.from_iterable(words),
            stdin=asyncio.subprocess.DEVNULL,
            stdout=asyncio.subprocess.DEVNULL,
            stderr=asyncio.subprocess.PIPE,
            preexec_fn=lambda: os.nice(_NICE),
        )
        try:
            _, said = await asyncio.wait_for(process.communicate(), LONGEST_S)
        except TimeoutError:
            process.kill()
            raise OSError(f"the report took longer than {LONGEST_S:g} s") from None
        if process.returncode or not path.is_file():
            lines = said.decode("utf-8", "replace").strip().splitlines()
            raise OSError(lines[-1] if lines else f"the command ended with {process.returncode}")
        return f"/report/{path.name}"
