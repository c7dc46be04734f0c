"""Keeps an asyncio process running until its stop signal, and its status file up to date."""

import asyncio
from collections.abc import Callable

from common.runtime.status_file import StatusFile

_EACH_S = 0.2
"""Interval between two checks of the stop signal, s."""


async def until_stopped(stop: Callable[[], bool], status: StatusFile, figures: Callable[[], dict[str, object]]) -> None:
    """Return after `stop()`; write `figures()` to the status file each second, and at the end."""
    loop = asyncio.get_running_loop()
    while not stop():
        if status.due(loop.time()):
            status.write(loop.time(), figures())
        await asyncio.sleep(_EACH_S)
    status.write(loop.time(), figures())
