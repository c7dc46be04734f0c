"""The state of a host's CAN controller, from the error frames that it reports (Linux, can/error.h).

A gateway passes on an error's class alone. Then a controller problem has no further name.
"""

from collections import Counter

TX_TIMEOUT, LOST_ARBITRATION, CONTROLLER, PROTOCOL = 0x001, 0x002, 0x004, 0x008
TRANSCEIVER, NO_ACKNOWLEDGE, BUS_OFF, BUS_ERROR, RESTARTED = 0x010, 0x020, 0x040, 0x080, 0x100
"""Classes: bits of an error frame's identifier."""
RX_OVERFLOW, TX_OVERFLOW, WARNING, PASSIVE, ACTIVE = 0x01, 0x02, 0x04 | 0x08, 0x10 | 0x20, 0x40
"""Details of the class CONTROLLER: bits of the frame's second byte."""

_CLASSES = {
    TX_TIMEOUT: "transmit time-out",
    LOST_ARBITRATION: "lost arbitration",
    PROTOCOL: "protocol error",
    TRANSCEIVER: "transceiver error",
    NO_ACKNOWLEDGE: "no acknowledge",
    BUS_ERROR: "bus error",
}
_DETAILS = {RX_OVERFLOW: "receive overflow", TX_OVERFLOW: "transmit overflow"}


class CanController:
    """Takes error frames; names what they say.

    Attributes:
        state: `error-active`, `warning`, `error-passive` or `bus off`.
        off: whether it has left the bus, as after too many errors: a short circuit, a wrong bit rate.
        counts: how often each error was reported, by name.
    """

    def __init__(self) -> None:
        """A controller that has reported nothing."""
        self.state = "error-active"
        self.off = False
        self.counts: Counter[str] = Counter()

    @property
    def errors(self) -> int:
        """How many errors were reported."""
        return self.counts.total()

    def alive(self) -> None:
        """A frame came through it: it is on the bus."""
        if self.off:
            self.state, self.off = "error-active", False

    def report(self, error: int, data: bytes) -> list[str]:
        """Take an error frame's class and bytes; returns the names of what it says, at least one."""
        found = [name for bit, name in _CLASSES.items() if error & bit]
        detail = data[1] if len(data) > 1 else 0
        if error & CONTROLLER:
            found += self._controller(detail)
        if error & RESTARTED:
            self.state, self.off = "error-active", False
            found.append("restarted")
        elif error & BUS_OFF:
            self.state, self.off = "bus off", True
            found.append("bus off")
        found = found or ["other error"]
        self.counts.update(found)
        return found

    def _controller(self, detail: int) -> list[str]:
        found = [name for bit, name in _DETAILS.items() if detail & bit]
        states = {PASSIVE: "error-passive", WARNING: "warning", ACTIVE: "error-active"}
        state = next((name for bits, name in states.items() if detail & bits), None)
        if state is not None:
            found.append(state)
            if not self.off:
                self.state = state
        return found or ["controller problem"]
