"""Tracks the state of a host's CAN controller from the error frames that it reports (Linux, can/error.h).

Some gateways forward the class of an error without its details. The error is then named "controller problem".
"""

from collections import Counter

TX_TIMEOUT, LOST_ARBITRATION, CONTROLLER, PROTOCOL = 0x001, 0x002, 0x004, 0x008
TRANSCEIVER, NO_ACKNOWLEDGE, BUS_OFF, BUS_ERROR, RESTARTED = 0x010, 0x020, 0x040, 0x080, 0x100
"""Error classes: bits of an error frame's identifier."""
RX_OVERFLOW, TX_OVERFLOW, WARNING, PASSIVE, ACTIVE = 0x01, 0x02, 0x04 | 0x08, 0x10 | 0x20, 0x40
"""Details of the class CONTROLLER: bits of the error frame's second byte."""

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
    """Decodes error frames into names of errors.

    Attributes:
        state: `error-active`, `warning`, `error-passive` or `bus off`.
        off: whether the controller has left the bus after too many errors, such as a short circuit or a wrong bit rate
            causes.
        counts: number of reports of each error, by name.
    """

    def __init__(self) -> None:
        self.state = "error-active"
        self.off = False
        self.counts: Counter[str] = Counter()

    @property
    def errors(self) -> int:
        """Number of reported errors."""
        return self.counts.total()

    def alive(self) -> None:
        """Note that a frame arrived: the controller is on the bus."""
        if self.off:
            self.state, self.off = "error-active", False

    def report(self, error: int, data: bytes) -> list[str]:
        """Take an error frame's class and bytes; return the names of its errors, at least one."""
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
