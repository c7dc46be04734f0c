"""Turns stream messages of a site or of its recording into the console's pictures, states and map tiles."""

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
from common.tenderness.patient_row import read_patient
from common.wire.messages import Touch
from common.wire.packets import LinkState
from operator_site.console.alarms.alarm_rules import Surroundings, causes, causes_unknown
from operator_site.console.alarms.alarms import Alarms
from operator_site.console.consent import Consent
from operator_site.console.examination.examination import Examination
from operator_site.console.map.lump_areas import NOTHING, Searched
from operator_site.console.map.patient_shift import PatientShift
from operator_site.console.map.tactile_map import TactileMap
from operator_site.console.state.calm_answers import CalmAnswers
from operator_site.console.state.fingers_now import FingersNow
from operator_site.console.state.frame import Flags, Frame, Kind
from operator_site.console.state.signals import BINS, SPAN_S, Signals
from operator_site.console.state.site_now import SiteNow
from operator_site.console.tenderness.pain_presses import ANSWER_OLD_S, PainPresses
from operator_site.console.tenderness.tender_search import NOT_SEARCHED, Tenderness
from operator_site.coupling.coupling import Coupling, Places
from operator_site.recorded_rows import Clock, Rendered, Skin
from operator_site.session.remote_status import RemotePatient

log = logging.getLogger(__name__)

ALARMS_EVERY_S = 0.1
"""Interval between two checks of the alarms of a recording, s of its time."""
_HZ_PER_RPM = 1.0 / 60.0
_DRAWN = {
    CONNECTED: LinkState.CONNECTED,
    ENGAGING: LinkState.CONNECTED,
    PAUSED: LinkState.CONNECTED,
    ENGAGED: LinkState.ENGAGED,
    FAULT: LinkState.FAULT,
    STOPPED: LinkState.FAULT,
}
"""Link state in a picture for each session state; a lost or silent link is drawn as disconnected."""


@dataclass(slots=True)
class Console:
    """Model of the console. Pure: time is an argument, s of the operator site's monotonic clock.

    Attributes:
        live: whether the messages come from a running site; False for a recording.
        around: state of the disk, the recording and the page, from the console's process.
        noted: what the patient agrees to have recorded, by the configuration; None where nobody has asked.
        calm: the last sure answer of each finger, for the pages.
        searched: lumps on the map and the next place to press, from a search every few seconds.
        shift: whether the patient has moved under the map.
        pain: presses with the patient's answers.
        tenderness: the most tender place, from a search every few seconds.
        damaged: number of unreadable messages, which are dropped.
    """

    live: bool = True
    around: Surroundings = field(default_factory=Surroundings)
    noted: tuple[str, ...] | None = None
    site: SiteNow = field(default_factory=SiteNow)
    fingers: FingersNow = field(default_factory=FingersNow)
    calm: CalmAnswers = field(default_factory=CalmAnswers)
    signals: Signals = field(default_factory=Signals)
    tactile_map: TactileMap = field(default_factory=TactileMap)
    searched: Searched = NOTHING
    shift: PatientShift = field(default_factory=PatientShift)
    pain: PainPresses = field(default_factory=PainPresses)
    tenderness: Tenderness = NOT_SEARCHED
    alarms: Alarms = field(default_factory=Alarms)
    examination: Examination = field(default_factory=Examination)
    damaged: int = 0
    map_number: int = 0
    """Number of the map; grows with every new map."""
    _stepped_s: float = -math.inf

    def __post_init__(self) -> None:
        """Begin without presses."""
        self._forget_pain()

    def take(self, stream: str, time_ns: int, payload: bytes) -> None:
        """Take one message; an unreadable one is counted and dropped."""
        try:
            self._take(stream, time_ns * 1e-9, payload)
        except Exception as error:  # one bad message must not stop the others
            if not self.damaged:
                log.warning("%s: %s", stream, error, exc_info=not isinstance(error, ValueError))
            self.damaged += 1
        # The alarms of a recording follow its own time: a moment must look the same after playing and after a jump.
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
            case "operator/coupling":
                self.site.coupling = Coupling.unpack(payload)
            case "operator/figures":
                self.site.take_figures(t_s, msgpack.unpackb(payload))
                self.tactile_map.roughness_um = self.site.roughness_um
            case "remote/patient":
                self._patient(t_s, payload)
            case "console/finding" | "console/session":
                record = msgpack.unpackb(payload)
                self.examination.take(stream, record)
                if stream == "console/session" and record["what"] == "begin":
                    self.begin_map()

    def _touch(self, t_s: float, touch: Touch) -> None:
        rows = touch.rows
        self.fingers.take_touch(t_s, touch, rows)
        self.site.link.take_touch(t_s, touch)
        self.signals.take(t_s, "contact_n", [[row.contact_force_n for row in rows]])
        self.tactile_map.add(t_s, rows, touch.summaries)
        if (movement := self.shift.step(t_s, rows)) is not None:
            self.tactile_map.moved_s = movement.since_s
        self.pain.take_touch(t_s, rows)

    def _rendered(self, t_s: float, row: Rendered) -> None:
        motor_hz = [rpm * _HZ_PER_RPM for rpm in row.motor_rpm]
        self.site.take_rendered(t_s, row.engaged, row.age_s)
        self.site.hand = Places(row.x_m, row.y_m, row.z_m)
        self.fingers.take_rendered(t_s, row.force_n, motor_hz, row.plate_c, row.plate_set_c, row.limits)
        self.signals.take(t_s, "force_n", [row.force_n])
        self.signals.take(t_s, "motor_hz", [motor_hz, self.fingers.plates_c(t_s)])

    def take_answer(self, now_s: float, answer: Mapping[str, Any]) -> None:
        """Take an answer of the site's local control."""
        self.site.answered_s = now_s
        before_s = self.site.patient_s
        self.site.take_brief(answer.get("time_ns", now_s * 1e9) * 1e-9, answer)
        if self.site.patient is not None and self.site.patient_s != before_s:
            self.pain.take_answer(self.site.patient_s, self.site.patient.pain, polled=True)

    def _patient(self, t_s: float, payload: bytes) -> None:
        """Take a recorded change of what the patient reports."""
        row = read_patient(payload)
        self.pain.take_answer(t_s, row.pain, polled=False)
        self.site.patient = RemotePatient(row.pain, row.limit_n, tuple(self.pain.reports), agreed=True)
        self.site.patient_s = t_s

    def begin_map(self) -> None:
        """Begin the map of another examination."""
        self.tactile_map = TactileMap(self.site.roughness_um)
        self.searched = NOTHING
        self.shift = PatientShift()
        self._forget_pain()
        self.map_number += 1

    def _forget_pain(self) -> None:
        """Begin without presses. A recording has an answer only where it changes, which counts until the next one."""
        self.pain = PainPresses(ANSWER_OLD_S if self.live else math.inf)
        self.tenderness = NOT_SEARCHED

    def step(self, now_s: float) -> None:
        """Update the alarms; called about thirty times a second."""
        self._stepped_s = now_s
        present = causes(now_s, self.site, self.fingers, self.in_use, self.around, live=self.live)
        self.alarms.step(now_s, present, complete=not causes_unknown(now_s, self.site, live=self.live))

    @property
    def in_use(self) -> tuple[bool, ...]:
        """Whether each finger is in use: it has a module, or the modules are unknown."""
        devices = self.site.ready
        return tuple(not devices or name in devices for name in FINGERS)

    @property
    def pain_agreed(self) -> bool:
        """Whether the patient agrees to have pain recorded, by the remote site and by this one where it has asked."""
        patient = self.site.patient
        return patient is not None and patient.agreed and not self.consent.forbids("pain")

    @property
    def consent(self) -> Consent:
        """What the patient agrees to have recorded, by both sites."""
        return Consent(self.noted, self.site.remote_consent)

    @property
    def recording(self) -> bool:
        """Whether the site records the session."""
        figures = self.site.figures
        return bool(figures.get("recorded")) and not figures.get("recording_failed")

    def word(self, now_s: float) -> str:
        """Return the state of the session in one word."""
        return self.site.word(now_s, live=self.live, pauses=self.examination.pseudonym is not None)

    def picture(self, now_s: float, sequence: int, after: int | None) -> bytes:
        """Return the encoded picture at `now_s`.

        Args:
            now_s: time, s.
            sequence: number of the picture, rising.
            after: newest bin that the page has; None or one that is too old gives all bins.
        """
        newest = self.signals.newest_bin(now_s)
        missing = BINS if after is None else newest - after
        whole = not 0 <= missing < BINS
        touching = self.fingers.in_contact(now_s)
        acting = [acts and used for acts, used in zip(self.fingers.acting(), self.in_use, strict=True)]
        flags = Flags(
            _DRAWN.get(self.word(now_s), LinkState.DISCONNECTED),
            self.alarms.priority,
            self.recording,
            not self.live,
            tuple(touching),
            tuple(acting),
            self.in_use,
        )
        return Frame(
            sequence,
            (newest + 1) * SPAN_S,
            flags,
            np.array(self.fingers.shown(now_s), dtype=np.float32),
            self.signals.bins(newest, BINS if whole else missing),
            self.site.session,
            Kind.WHOLE if whole else Kind.PICTURE,
        ).encode()
