"""Writes the report of an ended examination by a command in a process of its own."""

import asyncio
import logging
import os
import re
from collections.abc import Sequence
from itertools import chain
from pathlib import Path

from common.files.unique_path import free_name
from operator_site.console import texts

log = logging.getLogger(__name__)

SETTLED_S = 1.0
"""Time after the end until all records of the examination are on the disk, s."""
LONGEST_S = 1800.0
"""Longest time that the command may take, s."""
_NICE = 15
"""Niceness of the command."""
PLACE = "{report}"
"""Placeholder in the command for the path of the report."""
RECORD = "{record}"
"""Placeholder in the command for the files with the records of the examination."""


class Reporting:
    """Runs the configured report command."""

    def __init__(self, command: Sequence[str], folder: Path | None):
        """Set the command and the folder of the reports; without either there are no reports."""
        self._command, self._folder = list(command), folder
        self._one = asyncio.Lock()
        """Held while a report is written: the next one gets another name, and no two share the processor."""

    async def write(self, pseudonym: str, files: Sequence[Path]) -> str:
        """Write the report of an examination; return its address at the console's server.

        Raises:
            OSError: no report was written; the message says why.
        """
        if self._folder is None or not self._command:
            raise OSError(texts.NO_REPORT_CONFIGURED)
        await asyncio.sleep(SETTLED_S)
        async with self._one:
            return await self._write(self._folder, pseudonym, files)

    async def _write(self, folder: Path, pseudonym: str, files: Sequence[Path]) -> str:
        folder.mkdir(parents=True, exist_ok=True)
        # An earlier examination of the same person keeps its report.
        path = free_name(folder / (re.sub(r"[^\w-]", "_", pseudonym) + ".html"))
        words = [[*map(str, files)] if word == RECORD else [word.replace(PLACE, str(path))] for word in self._command]
        process = await asyncio.create_subprocess_exec(
            *chain.from_iterable(words),
            stdin=asyncio.subprocess.DEVNULL,
            stdout=asyncio.subprocess.DEVNULL,
            stderr=asyncio.subprocess.PIPE,
            preexec_fn=lambda: os.nice(_NICE),
        )
        try:
            _, errors = await asyncio.wait_for(process.communicate(), LONGEST_S)
        except TimeoutError:
            process.kill()
            raise OSError(texts.REPORT_LATE.format(seconds=LONGEST_S)) from None
        if process.returncode or not path.is_file():
            lines = errors.decode("utf-8", "replace").strip().splitlines()
            raise OSError(lines[-1] if lines else texts.REPORT_ENDED.format(code=process.returncode))
        return f"/report/{path.name}"
