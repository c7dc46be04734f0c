"""Delays, jitters and drops the packets of the netfilter queue whose number is its argument.

A program of its own: it needs NetfilterQueue and nothing else. Each line `DELAY_MS JITTER_MS LOSS RATE_KBIT_S` on its
input sets what happens to packets from then on (rate 0: no limit), and is answered with the numbers of packets passed
on and dropped so far. Packets keep their order. It ends with its input.
"""

import random
import select
import sys
import time
from collections import deque
from dataclasses import dataclass, field

from netfilterqueue import NetfilterQueue, Packet


@dataclass
class Impairment:
    """Packets on their way, and what happens to one that comes now."""

    rng: random.Random
    delay_s: float = 0.0
    jitter_s: float = 0.0
    loss: float = 0.0
    rate_bit_s: float = 0.0
    passed: int = 0
    dropped: int = 0
    _waiting: deque[tuple[float, Packet]] = field(default_factory=deque)
    _last_s: float = 0.0
    _sent_s: float = 0.0
    """When the last bit has left at the limited rate."""

    def take(self, packet: Packet) -> None:
        """Decide on one packet: it is dropped, or due at a time, never before the one ahead of it."""
        if self.rng.random() < self.loss:
            self.dropped += 1
            packet.drop()
            return
        delay_s = max(0.0, self.rng.gauss(self.delay_s, self.jitter_s))
        now_s = time.monotonic()
        takes_s = 8 * packet.get_payload_len() / self.rate_bit_s if self.rate_bit_s else 0.0
        self._sent_s = max(self._sent_s, now_s) + takes_s
        self._last_s = max(self._last_s, self._sent_s + delay_s)
        self._waiting.append((self._last_s, packet))

    def release(self) -> float | None:
        """Let go of what is due; return after how many seconds the next one is, None when none waits."""
        while self._waiting:
            left_s = self._waiting[0][0] - time.monotonic()
            if left_s > 0.0:
                return left_s
            self._waiting.popleft()[1].accept()
            self.passed += 1
        return None


def main() -> None:
    """Serve the queue until the input ends."""
    impairment, queue = Impairment(random.Random(1)), NetfilterQueue()
    queue.bind(int(sys.argv[1]), impairment.take, max_len=10_000)
    print("ready", flush=True)
    while True:
        readable, _, _ = select.select([sys.stdin, queue.get_fd()], [], [], impairment.release())
        if queue.get_fd() in readable:
            queue.run(block=False)
        if sys.stdin in readable:
            line = sys.stdin.readline()
            if not line:
                return
            delay_ms, jitter_ms, impairment.loss, rate_kbit_s = (float(word) for word in line.split())
            impairment.delay_s, impairment.jitter_s = delay_ms / 1e3, jitter_ms / 1e3
            impairment.rate_bit_s = 1e3 * rate_kbit_s
            print(impairment.passed, impairment.dropped, flush=True)


if __name__ == "__main__":
    main()
