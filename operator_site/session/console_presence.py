"""Whether somebody watches: a page that is hidden has no key for an emergency stop, and nobody sees its alarms."""

from dataclasses import dataclass


@dataclass(slots=True)
class ConsolePresence:
    """Counts how long the acting console was away while engaged. Pure: time is an argument, ns.

    Attributes:
        required_s: it may be away for so long, s; 0 where nobody has to watch.
    """

    required_s: float
    _seen_ns: int = 0
    _hidden: bool = False

    def told(self, now_ns: int, seen: bool) -> None:
        """A console said whether a person can see and use it."""
        if seen:
            self._seen_ns = now_ns
        self._hidden = not seen

    def step(self, now_ns: int, engaged: bool) -> str:
        """Why the site must pause; empty when it need not. Whoever engages has as long to be seen."""
        if not self.required_s or not engaged:
            self._seen_ns = now_ns
            return ""
        self._seen_ns = min(self._seen_ns, now_ns)  # the clock was set back
        if now_ns - self._seen_ns <= self.required_s * 1e9:
            return ""
        return f"console was {'hidden' if self._hidden else 'silent'} for {self.required_s:g} s"
