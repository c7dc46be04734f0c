"""The remote site's end of a link under test: sends touch at 500 Hz and answers heartbeats, until its input ends.

    remote_end.py ADDRESS BASE_PORT KEYS

Its clock is far from the operator's, as two hosts' clocks are.
"""

import json
import select
import sys
import time
from pathlib import Path

import numpy as np

from common.link.keys import TrustedKeys, load_keys
from common.link.link import RemoteLink
from common.runtime.periodic_loop import PeriodicLoop
from common.runtime.scheduling import become_timely
from common.wire.messages import TOUCH_BLOCK, TOUCH_FIELDS, Touch
from common.wire.packets import LinkState
from common.wire.session_messages import Heartbeat
from common.wire.streams import STREAMS

SESSION = 1
CLOCK_APART_NS = 7_200_000_000_123
"""This end's clock minus the operator's."""


def now_ns() -> int:
    """This end's clock."""
    return time.monotonic_ns() + CLOCK_APART_NS


def main(address: str, base_port: int, keys: Path) -> None:
    """Serve until the input ends, then print how much was sent."""
    sent = 0
    block = np.zeros((5, len(TOUCH_FIELDS)), np.float32)
    with RemoteLink(address, base_port, load_keys(keys), TrustedKeys(keys)) as link:
        print("bound", flush=True)
        become_timely()
        loop = PeriodicLoop(1.0 / STREAMS["touch"].rate_hz)
        while not select.select([sys.stdin], [], [], 0.0)[0]:
            loop.wait()
            for sender, packet in link.requests("heartbeat"):
                arrived_ns = now_ns()
                asked = Heartbeat.decode(packet)
                answer = (asked.sent_ns, arrived_ns, asked.offset_ns, asked.uncertainty_ns)
                beat = Heartbeat(SESSION, asked.sequence, now_ns(), LinkState.ENGAGED, *answer)
                link.answer("heartbeat", sender.who, beat.encode())
            sent += 1
            touch = Touch(SESSION, sent, now_ns(), LinkState.ENGAGED, TOUCH_BLOCK.to_bytes(block), ("",) * 5, ())
            link.send_latest("touch", touch.encode())
    print(json.dumps({"sent": sent}), flush=True)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), Path(sys.argv[3]))
