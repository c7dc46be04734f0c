"""Pages without a browser that receive all that a console sends.

`python -m benchmarks.consoles.pages ADDRESS COUNT` runs them.

Each page confirms every picture at once and reports that it is visible, as a page on a screen does. The pages run in a
process of their own, so that their processor time does not count as the console's. That process has low priority, since
real browsers run on other machines. When terminated it prints what each page received, as JSON.
"""

import asyncio
import contextlib
import json
import signal
import sys
from collections import Counter

from websockets.asyncio.client import ClientConnection, connect
from websockets.typing import Origin

from common.runtime.scheduling import give_way
from operator_site.console.state.frame import HEADER, Kind

_ALIVE_S = 0.5
_LEAST = 19
_MOST_BYTES = 1 << 20


async def look(address: str, sent: Counter[str]) -> None:
    """Run one page until cancelled, and count what it receives."""
    socket = address.replace("http", "ws", 1) + "/session"
    async with connect(socket, origin=Origin(address), max_size=_MOST_BYTES) as page:
        alive = asyncio.create_task(_say_alive(page))
        try:
            async for message in page:
                sent["bytes"] += len(message)
                if isinstance(message, str):
                    sent["states"] += 1
                elif message[3] == Kind.TILE:
                    sent["tiles"] += 1
                else:
                    sent["pictures"] += 1
                    await page.send(json.dumps({"kind": "drawn", "sequence": HEADER.unpack_from(message)[4]}))
        finally:
            alive.cancel()


async def _say_alive(page: ClientConnection) -> None:
    while True:
        await page.send(json.dumps({"kind": "alive", "visible": True, "sequence": 0}))
        await asyncio.sleep(_ALIVE_S)


async def main(address: str, count: int) -> None:
    """Open the pages, and receive until SIGTERM."""
    give_way(_LEAST)
    sent = [Counter[str]() for _ in range(count)]
    looking = asyncio.gather(*(look(address, counted) for counted in sent))
    asyncio.get_running_loop().add_signal_handler(signal.SIGTERM, looking.cancel)
    with contextlib.suppress(asyncio.CancelledError):
        await looking
        raise ConnectionError("the console closed its pages")
    print(json.dumps(sent))


if __name__ == "__main__":
    asyncio.run(main(sys.argv[1], int(sys.argv[2])))
