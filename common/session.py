"""The session's states, the same on both sites: disconnected, connected, engaged, fault (latched)."""

from dataclasses import dataclass

from common.packets import LinkState


class Refused(ValueError):
    """A request that the present state does not allow; the message says why and what to do."""


@dataclass(slots=True)
class Session:
    """One site's session state. Outputs are possible in ENGAGED only; a fault latches."""

    state: LinkState = LinkState.DISCONNECTED
    ident: int = 0
    """Number of the session, chosen by the remote site at hello; 0 while there is none."""
    fault: str = ""

    @property
    def engaged(self) -> bool:
        """Whether outputs may leave neutral."""
        return self.state is LinkState.ENGAGED

    def connect(self, ident: int) -> None:
        """A far side said hello: a new session begins, not engaged. A latched fault stays.

        Raises:
            ValueError: the session's number is not positive.
        """
        if ident <= 0:
            raise ValueError(f"session number {ident} is not positive")
        self.ident = ident
        if self.state is not LinkState.FAULT:
            self.state = LinkState.CONNECTED

    def disconnect(self) -> None:
        """The far side is gone. A latched fault stays, and somebody may connect anew to clear it."""
        self.ident = 0
        if self.state is not LinkState.FAULT:
            self.state = LinkState.DISCONNECTED

    def engage(self) -> None:
        """Let outputs leave neutral.

        Raises:
            Refused: there is no far side, or a fault is latched.
        """
        if self.state is LinkState.FAULT:
            raise Refused(f"a fault is latched ({self.fault}): clear it first")
        if self.state is LinkState.DISCONNECTED:
            raise Refused("no far side is connected: say hello first")
        self.state = LinkState.ENGAGED

    def disengage(self) -> None:
        """Bring outputs to neutral; always allowed."""
        if self.state is LinkState.ENGAGED:
            self.state = LinkState.CONNECTED

    def latch(self, why: str) -> None:
        """Latch a fault: neutral until it is deliberately cleared. The first fault's reason is kept."""
        if self.state is not LinkState.FAULT:
            self.fault = why
            self.state = LinkState.FAULT

    def clear(self) -> None:
        """Clear a latched fault. Nothing moves by it: the session must be engaged again.

        Raises:
            Refused: no fault is latched.
        """
        if self.state is not LinkState.FAULT:
            raise Refused("no fault is latched")
        self.fault = ""
        self.state = LinkState.CONNECTED if self.ident else LinkState.DISCONNECTED
