"""The whole remote site against trusted operators and read-only clients that send any packet that decoders accept."""

from collections import defaultdict
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from common.buses.can_address import CanAddress
from common.config.link_models import RemoteLinkConfig
from common.config.site_models import CalibrationConfig, RemoteConfig
from common.faults.fault import Fault
from common.fingers import FINGERS
from common.link.curve import Received, Sender
from common.link.link import RemoteLink
from common.link.session_state import Refused
from common.recording.recorder import Recorder
from common.timing.tick_age import TickAge
from common.wire.messages import MOTION_BLOCK, Touch, motion_packet
from common.wire.packets import BadPacket, LinkState
from common.wire.session_messages import Answer, Heartbeat, Request
from remote_site.devices.devices import RemoteDevices
from remote_site.devices.sensor_frame import HandPlace, PlateReading, SensorFrame
from remote_site.devices.telemanipulator import Measured
from remote_site.safety.setpoints import PLANE_RANGE_M, GatedCommand
from remote_site.session.local_control import answer_desk
from remote_site.site import RemoteSite
from teletaction.session.demo_files import SURFACES, TABLES
from tests.robustness.hardening.strange_packets import (
    FUZZ,
    MS,
    SEQUENCES,
    able,
    details,
    gaps_ms,
    integers,
    motion_blocks,
    states,
    verbs,
)
from tests.virtual.kept_record import KeptRecord

pytestmark = [pytest.mark.hardening, pytest.mark.timeout(600 + SEQUENCES)]

CONFIG = RemoteConfig(
    fingers=FINGERS,
    link=RemoteLinkConfig(keys=Path("keys")),
    texture={finger: f"texture-{finger}" for finger in FINGERS},
    thermal_sensors={finger: f"thermal-{finger}" for finger in FINGERS},
    telemanipulator=CanAddress(interface="virtual"),
    calibration=CalibrationConfig(materials=TABLES / "materials.json", surfaces=SURFACES),
)
OPERATOR, SECOND, OBSERVER = (name.ljust(40, "x") for name in ("operator", "second", "observer"))
keys = st.sampled_from([OPERATOR, OPERATOR, SECOND, OBSERVER])
SILENCE_TICKS = 150
_REST = np.zeros((len(FINGERS), 3), dtype=np.float32)


class FarSide:
    """The link, with what the site sent and what it will receive."""

    def __init__(self) -> None:
        self.handshakes: dict[str, int] = {}
        self.answers: dict[str, list[bytes]] = defaultdict(list)
        self.coming: dict[str, list[Received]] = defaultdict(list)
        self.touch: bytes | None = None

    def come(self, stream: str, key: str, packet: bytes) -> None:
        """Let a packet of a key arrive before the next tick."""
        self.coming[stream].append((Sender(key.encode(), key), packet))

    def requests(self, stream: str) -> list[Received]:
        return self.coming.pop(stream, [])

    def newest_of_each(self, stream: str) -> list[Received]:
        return self.coming.pop(stream, [])

    def answer(self, stream: str, who: bytes, packet: bytes) -> None:
        self.answers[stream] = [*self.answers[stream][-8:], packet]

    def send_latest(self, stream: str, packet: bytes) -> None:
        self.touch = packet

    def may_operate(self, key: str) -> bool:
        return key != OBSERVER

    def recheck_keys(self) -> set[str]:
        return set()

    def __getattr__(self, name: str) -> Any:
        return lambda *given, **named: None


@dataclass
class Devices:
    """A telemanipulator that is where it is sent, over something soft at height 0."""

    telemanipulator: Any = field(default_factory=lambda: SimpleNamespace(measured=Measured()))
    sensor_c: list[float] = field(default_factory=lambda: [30.0] * len(FINGERS))
    sensor_s: list[float] = field(default_factory=lambda: [0.0] * len(FINGERS))
    tick: TickAge = field(default_factory=TickAge)
    command: GatedCommand | None = None
    follows: bool = True
    ticks: int = 0

    def read(self, t_s: float, hand: HandPlace | None = None) -> SensorFrame:
        self.ticks += 1
        measured, command = self.telemanipulator.measured, self.command
        if command is not None and command.ready:
            measured.x_m, measured.y_m = command.x_m, command.y_m
            measured.z_m = tuple(command.z_m)
        measured.force_n = tuple(round(min(4.0, max(0.0, -400.0 * z_m)), 2) for z_m in measured.z_m)
        measured.pose_s = measured.heights_s = measured.force_s = t_s
        self.sensor_s = [t_s] * len(FINGERS)
        counts = (np.arange(8) * 7 % 5 + self.ticks % 3).astype("<i2").tobytes()
        plate = PlateReading(30.0, 23.0, "", self.ticks * 2000 % 2**32, 0)
        plates = (plate if self.ticks % 5 == 0 else None,) * len(FINGERS)
        return SensorFrame(
            t_s,
            measured.x_m,
            measured.y_m,
            measured.z_m,
            measured.force_n,
            (counts,) * len(FINGERS),
            plates,
            hand,
        )

    def missing(self) -> str:
        return ""

    def faults(self) -> list[Fault]:
        return []

    def write(self, command: GatedCommand, sensed: SensorFrame) -> None:
        self.command = command

    def switch_reading(self, t_s: float) -> None:
        return None

    def pain_reading(self, t_s: float) -> None:
        return None

    def unconfirmed(self, since_s: float) -> dict[str, str]:
        return {}

    def figures(self) -> dict[str, object]:
        return {}


class RemoteAgainstOperators(RuleBasedStateMachine):
    """Packets and times in any order; nothing is contained, and every command is within its limits."""

    def __init__(self) -> None:
        super().__init__()
        self.far, self.devices, self.kept = FarSide(), Devices(), KeptRecord()
        recorder = cast(Recorder, self.kept)
        self.site = RemoteSite(CONFIG, cast(RemoteLink, self.far), cast(RemoteDevices, self.devices), recorder)
        self.now_ns, self.sequence, self.motions, self.offset_ns = 100_000 * MS, 0, 0, 0

    @property
    def ident(self) -> int:
        """Number of the session that is."""
        return self.site.server.session.ident

    @initialize(engage=st.booleans())
    def begin(self, engage: bool) -> None:
        """Mostly both sites are engaged before the lies begin."""
        if engage:
            self.honest(6)

    @rule(ticks=st.integers(1, 12))
    def honest(self, ticks: int) -> None:
        """An honest operator for some ticks: hello, heartbeats, engage, and a hand that moves slowly."""
        if not self.ident:
            self.ask(OPERATOR, "hello", {**able(FINGERS), "role": "operator"})
            self.tick(2)
        self.offset_ns = 0
        self.beat(OPERATOR, LinkState.ENGAGED, 0, MS)
        self.ask(OPERATOR, "engage", {"max_age_s": 0.15})
        for _ in range(ticks):
            self.move(LinkState.ENGAGED, _REST.tobytes())
            self.tick(2)

    def ask(self, key: str, verb: str, given: dict[str, Any], sequence: int | None = None, ident: int = -1) -> None:
        """Let a request arrive."""
        self.sequence += 1
        number = self.sequence if sequence is None else sequence
        with suppress(BadPacket):  # longer than a packet may be
            packet = Request(self.ident if ident < 0 else ident, number, 0, verb, given).encode()
            self.far.come("control", key, packet)

    def beat(self, key: str, state: LinkState, offset_ns: int, uncertainty_ns: int) -> None:
        """Let a heartbeat arrive."""
        beat = Heartbeat(self.ident, 1, self.now_ns, state, self.now_ns, 0, offset_ns, uncertainty_ns)
        self.far.come("heartbeat", key, beat.encode())

    def move(self, state: LinkState, floats: bytes, late_ms: int = 0) -> None:
        """Let a motion arrive that the site accepts while it believes the offset of the clocks."""
        self.motions += 1
        # The operator found (remote - operator); its own time is this site's less that.
        time_ns = min(2**63 - 1, max(0, self.now_ns - self.offset_ns - late_ms * MS))
        self.far.come("motion", OPERATOR, motion_packet(self.ident, self.motions, time_ns, state, floats))

    @rule(gap_ms=gaps_ms)
    def tick(self, gap_ms: int) -> None:
        """Let time pass; the site ticks."""
        self.now_ns = max(1_000 * MS, self.now_ns + gap_ms * MS)
        self.site.tick(self.now_ns)

    @rule(
        state=st.one_of(st.just(LinkState.ENGAGED), states),
        floats=motion_blocks,
        skip=st.sampled_from([0, 0, 0, 1, 9_999, 20_000]),
        late_ms=st.integers(-10, 160),
    )
    def strange_motion(self, state: LinkState, floats: bytes, skip: int, late_ms: int) -> None:
        """A motion that jumps anywhere, and a tick."""
        self.motions += skip
        self.move(state, floats, late_ms)
        self.tick(2)

    @rule(key=keys, state=states, offset=st.integers(-(2**63), 2**63 - 1), uncertainty=st.sampled_from([0, 1, MS]))
    def strange_heartbeat(self, key: str, state: LinkState, offset: int, uncertainty: int) -> None:
        """A heartbeat with an offset of its own, and motion of the time that it makes."""
        self.beat(key, state, offset, uncertainty)
        if key == OPERATOR:
            self.offset_ns = offset
        self.tick(2)

    @rule(key=keys, uncertainty=integers)
    def uncertain_heartbeat(self, key: str, uncertainty: int) -> None:
        """A heartbeat that knows the clocks as badly as it says."""
        self.beat(key, LinkState.CONNECTED, 0, uncertainty)
        self.tick(2)

    @rule(
        key=keys,
        verb=verbs,
        given=details,
        honest=st.booleans(),
        sequence=st.one_of(st.none(), st.none(), integers),
        ident=st.sampled_from([-1, -1, -1, 0, 5]),
    )
    def strange_request(
        self, key: str, verb: str, given: dict[str, Any], honest: bool, sequence: int | None, ident: int
    ) -> None:
        """A request of any key in any order."""
        if honest:
            given = {**able(FINGERS), "max_age_s": 0.1, "text": "a note", **given}
        self.ask(key, verb, given, sequence, ident)
        self.tick(2)

    @rule(verb=verbs)
    def person(self, verb: str) -> None:
        """The person at the patient's side asks for something."""
        with suppress(Refused):
            answer_desk(self.site.server, self.now_ns, "", verb)
        self.tick(2)

    @rule()
    def status(self) -> None:
        """The status file is written."""
        self.site.figures()

    @invariant()
    def nothing_is_contained(self) -> None:
        assert self.site.contain.count == 0, dict(self.site.contain.latest)

    @invariant()
    def what_was_sent_can_be_read(self) -> None:
        if self.far.touch is not None:
            Touch.decode(self.far.touch)
        for packet in self.far.answers.pop("control", []):
            Answer.decode(packet)
        for packet in self.far.answers.pop("heartbeat", []):
            Heartbeat.decode(packet)

    @precondition(lambda self: self.devices.command is not None)
    @invariant()
    def commands_are_within_limits(self) -> None:
        command = self.devices.command
        assert command is not None
        assert abs(command.x_m) <= PLANE_RANGE_M
        assert abs(command.y_m) <= PLANE_RANGE_M
        low, high = MOTION_BLOCK.low[2] - 1e-6, MOTION_BLOCK.high[2] + 1e-6
        assert all(low <= z_m <= high for z_m in command.z_m)
        assert all(-1.0 <= drive <= 1.0 for drive in command.heater_drive)

    def teardown(self) -> None:
        """Silence: released, and every heater off, in the end."""
        for _ in range(SILENCE_TICKS):
            self.now_ns += 2 * MS
            self.site.tick(self.now_ns)
        self.nothing_is_contained()
        command = self.devices.command
        assert command is not None
        assert command.released
        assert command.heater_drive == [0.0] * len(FINGERS)


RemoteAgainstOperators.TestCase.settings = FUZZ
TestRemoteAgainstOperators = RemoteAgainstOperators.TestCase
