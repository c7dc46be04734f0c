"""Monitors whether a person watches the console; a hidden page has no emergency-stop key and shows no alarms."""

from dataclasses import dataclass


@dataclass(slots=True)
class ConsolePresence:
    """Measures the absence of the acting console while engaged. Pure: time is an argument, ns.

    Attributes:
        required_s: longest allowed absence, s; 0 if nobody needs to watch.
    """

    required_s: float
    _seen_ns: int = 0
    _hidden: bool = False

    def report(self, now_ns: int, seen: bool) -> None:
        """Take a console's report whether a person can see and use it."""
        if seen:
            self._seen_ns = now_ns
        self._hidden = not seen

    def step(self, now_ns: int, engaged: bool) -> str:
        """Return why the site must pause, or an empty text.

        After engaging, the console has `required_s` to send its first presence message.
        """
        if not self.required_s or not engaged:
            self._seen_ns = now_ns
            return ""
        self._seen_ns = min(self._seen_ns, now_ns)  # the clock was set back
        if now_ns - self._seen_ns <= self.required_s * 1e9:
            return ""
        return f"console was {'hidden' if self._hidden else 'silent'} for {self.required_s:g} s"
