"""The console's knowledge: stream messages of a site or of its recording go in, pictures, states and tiles come out."""

import logging
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import msgpack
import numpy as np

from common.fingers import FINGERS
from common.link.session_display import CONNECTED, ENGAGED, ENGAGING, FAULT, PAUSED, STOPPED
from common.link.session_state import Happening
from common.wire.messages import Touch
from common.wire.packets import LinkState
from operator_site.console.alarms.alarm_rules import Surroundings, causes
from operator_site.console.alarms.alarms import Alarms
from operator_site.console.examination.examination import Examination
from operator_site.console.map.map_tiles import MapTile, changed
from operator_site.console.map.tactile_map import TactileMap
from operator_site.console.state.fingers_now import FingersNow
from operator_site.console.state.frame import Flags, Frame, Kind
from operator_site.console.state.signals import BINS, SPAN_S, Signals
from operator_site.console.state.site_now import SiteNow
from operator_site.recorded_rows import Clock, Rendered, Skin

log = logging.getLogger(__name__)

ALARMS_EVERY_S = 0.1
"""Of a recording's time."""
_HZ_PER_RPM = 1.0 / 60.0
_DRAWN = {
    CONNECTED: LinkState.CONNECTED,
    ENGAGING: LinkState.CONNECTED,
    PAUSED: LinkState.CONNECTED,
    ENGAGED: LinkState.ENGAGED,
    FAULT: LinkState.FAULT,
    STOPPED: LinkState.FAULT,
}
"""How a picture says the state; what is lost or silent is drawn as disconnected."""


@dataclass(slots=True)
class Console:
    """Pure: time is an argument, s of the operator site's monotonic clock.

    Attributes:
        live: what it is fed happens now; a recording else.
        around: what its process knows of the world around it.
        damaged: messages that could not be read, which are dropped.
    """

    live: bool = True
    around: Surroundings = field(default_factory=Surroundings)
    site: SiteNow = field(default_factory=SiteNow)
    fingers: FingersNow = field(default_factory=FingersNow)
    signals: Signals = field(default_factory=Signals)
    felt: TactileMap = field(default_factory=TactileMap)
    alarms: Alarms = field(default_factory=Alarms)
    book: Examination = field(default_factory=Examination)
    damaged: int = 0
    map_number: int = 0
    """Grows when the map begins anew."""
    _stepped_s: float = -math.inf

    def take(self, stream: str, time_ns: int, payload: bytes) -> None:
        """Take one message; what cannot be read is counted and dropped."""
        try:
            self._take(stream, time_ns * 1e-9, payload)
        except Exception as error:  # whatever is wrong with one message, the others are still to be shown
            if not self.damaged:
                log.warning("%s: %s", stream, error, exc_info=not isinstance(error, ValueError))
            self.damaged += 1
        # What a recording shows at a moment must not depend on how one came there: its own time makes its alarms.
        if not self.live and not 0.0 <= time_ns * 1e-9 - self._stepped_s < ALARMS_EVERY_S:
            self.step(time_ns * 1e-9)

    def _take(self, stream: str, t_s: float, payload: bytes) -> None:
        self.site.heard_s = t_s
        match stream:
            case "operator/touch":
                self._touch(t_s, Touch.decode(payload))
            case "operator/rendered":
                self._rendered(t_s, Rendered.unpack(payload))
            case "operator/skin":
                skin_c = Skin.unpack(payload).felt_c
                self.fingers.take_skin(t_s, skin_c)
                self.signals.take(t_s, "skin_c", [skin_c])
            case "operator/clock":
                clock = Clock.unpack(payload)
                self.site.link.take_clock(clock.offset_ns, clock.uncertainty_ns)
            case "operator/session":
                self.site.take_happening(t_s, Happening.unpack(payload))
            case "operator/figures":
                self.site.take_figures(t_s, msgpack.unpackb(payload))
            case "console/finding" | "console/session":
                record = msgpack.unpackb(payload)
                self.book.take(stream, record)
                if stream == "console/session" and record["what"] == "begin":
                    self.begin_anew()

    def _touch(self, t_s: float, touch: Touch) -> None:
        rows = touch.rows
        self.fingers.take_touch(t_s, touch, rows)
        self.site.link.take_touch(t_s, touch)
        self.signals.take(t_s, "contact_n", [[row.contact_force_n for row in rows]])
        self.felt.felt(t_s, rows, touch.told)

    def _rendered(self, t_s: float, row: Rendered) -> None:
        motor_hz = [rpm * _HZ_PER_RPM for rpm in row.motor_rpm]
        self.site.take_rendered(t_s, row.engaged, row.age_s)
        self.fingers.take_rendered(t_s, row.force_n, motor_hz, row.plate_c, row.plate_set_c, row.limits)
        self.signals.take(t_s, "force_n", [row.force_n])
        self.signals.take(t_s, "motor_hz", [motor_hz, self.fingers.plates_c(t_s)])

    def desk(self, now_s: float, told: Mapping[str, Any]) -> None:
        """Take an answer of the site's desk."""
        self.site.desk_s = now_s
        self.site.take_brief(told.get("time_ns", now_s * 1e9) * 1e-9, told)

    def begin_anew(self) -> None:
        """Another examination begins: its map is its own."""
        self.felt = TactileMap()
        self.map_number += 1

    def step(self, now_s: float) -> None:
        """Judge what is wrong; called some thirty times a second."""
        self._stepped_s = now_s
        self.alarms.step(now_s, causes(now_s, self.site, self.fingers, self.in_use, self.around, live=self.live))

    @property
    def in_use(self) -> tuple[bool, ...]:
        """Which fingers take part: those that have a module, all where that is not known."""
        devices = self.site.ready
        return tuple(not devices or name in devices for name in FINGERS)

    @property
    def recording(self) -> bool:
        """Whether what goes on is kept."""
        figures = self.site.figures
        return bool(figures.get("recorded")) and not figures.get("recording_failed")

    def word(self, now_s: float) -> str:
        """The state of the session, in one word."""
        return self.site.word(now_s, live=self.live, pauses=self.book.pseudonym is not None)

    def newest_bin(self, now_s: float) -> int:
        """Number of the newest bin that a picture of now would hold."""
        return self.signals.newest_bin(now_s)

    def picture(self, now_s: float, sequence: int, after: int | None) -> bytes:
        """A picture of now.

        Args:
            now_s: s.
            sequence: number of the picture, rising.
            after: the newest bin that the page has; None gives it all there is, as does one that is too old.
        """
        newest = self.newest_bin(now_s)
        whole = after is None or not 0 <= newest - after < BINS
        touching = self.fingers.in_contact(now_s)
        acting = [acts and used for acts, used in zip(self.fingers.acting(now_s), self.in_use, strict=True)]
        flags = Flags(
            _DRAWN.get(self.word(now_s), LinkState.DISCONNECTED),
            self.alarms.priority,
            self.recording,
            not self.live,
            tuple(touching),
            tuple(acting),
            self.in_use,
        )
        missing = BINS if whole or after is None else newest - after
        return Frame(
            sequence,
            (newest + 1) * SPAN_S,
            flags,
            np.array(self.fingers.shown(now_s), dtype=np.float32),
            self.signals.bins(newest, missing),
            self.site.session,
            Kind.WHOLE if whole else Kind.PICTURE,
        ).encode()

    def tiles(self, quantity: str, since: int) -> list[MapTile]:
        """Tiles of a quantity that changed after a revision of the map, those that have waited longest first."""
        return changed(self.felt, quantity, since)

    def clock_s(self, now_s: float) -> float | None:
        """How long the examination has been going on; None while none is."""
        began_s = self.book.began_s
        return None if self.book.pseudonym is None or began_s is None else max(0.0, now_s - began_s)

    def age_s(self, now_s: float) -> float | None:
        """Of what is shown; None where nothing ever came."""
        age_s = self.fingers.age_s(now_s)
        return age_s if math.isfinite(age_s) else None
