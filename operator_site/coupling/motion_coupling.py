"""Keeps the present coupling of the hand, and changes it as the operator asks."""

from collections.abc import Callable, Mapping

from common.limits import MOTION_SCALES
from common.link.session_state import Refused
from operator_site.coupling.coupling import AT_ORIGIN, DIRECT, Coupling, Places, limited

Note = Callable[[str, str], None]
"""Notes an event of the session, with its text."""


class MotionCoupling:
    """Pure: the hand's place is an argument of `step`, m.

    Attributes:
        now: the present coupling; another object after each change.
        pressed_n: largest force on a finger of the hand, N; the scale does not change while one presses.
    """

    def __init__(self, note: Note) -> None:
        """Begin with the direct coupling; `note` notes changes."""
        self.now: Coupling = DIRECT
        self.pressed_n = 0.0
        self._note = note
        self._engaged = False
        self._session = 0
        self._hand = AT_ORIGIN

    def step(self, engaged: bool, session: int, hand: Places) -> None:
        """Take the session's state and the hand's place, m.

        A new session begins with the direct coupling. Engaging closes an open clutch at the hand's place.
        """
        self._hand = hand
        if session and session != self._session:
            self._session = session
            self.now = DIRECT
        if engaged is not self._engaged:
            self._engaged = engaged
            if engaged:
                self._clutch(False)

    def ask(self, verb: str, details: Mapping[str, object]) -> None:
        """Carry out a request: `clutch` with `open`, or `scale` with `scale`.

        Raises:
            Refused: a detail is missing or wrong, or the request is not possible now.
        """
        if verb == "clutch":
            wanted = details.get("open")
            if not isinstance(wanted, bool):
                raise Refused("clutch needs open: true or false")
            if wanted and not self._engaged:
                raise Refused("the clutch opens only while engaged")
            self._clutch(wanted)
        else:
            self._rescale(details.get("scale"))

    def _clutch(self, wanted: bool) -> None:
        """Open or close the clutch at the present place of the hand."""
        before = self.now
        if wanted is before.open:
            return
        command = before.unlimited(self._hand)
        # A hand beyond the edge keeps its force while the clutch opens, and starts at the edge when it closes.
        self._begin(wanted, before.scale, command if wanted else limited(command))
        self._note("clutch", "open" if wanted else "closed")

    def _rescale(self, scale: object) -> None:
        """Change the motion scale at the present place of the hand."""
        if type(scale) is not int or scale not in MOTION_SCALES:
            raise Refused(f"the motion scale is one of {', '.join(f'1:{n}' for n in MOTION_SCALES)}")
        before = self.now
        if scale == before.scale:
            return
        if self.pressed_n > 0.0:
            raise Refused("a finger presses: lift it, or open the clutch, then change the scale")
        self._begin(before.open, scale, before.unlimited(self._hand))
        self._note("scale", f"1:{scale}")

    def _begin(self, is_open: bool, scale: int, command: Places) -> None:
        self.now = Coupling(is_open, scale, *self._hand, *command)
