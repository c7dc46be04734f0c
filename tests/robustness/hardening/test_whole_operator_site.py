"""The whole operator's site against a trusted remote site that sends any packet that decoders accept."""

import math
from collections import defaultdict
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from common.buses.can_address import CanAddress
from common.config.link_models import OperatorLinkConfig
from common.config.site_models import OperatorConfig
from common.faults.fault import Fault
from common.fingers import FINGERS
from common.limits import FINGER_FORCE_N, MOTOR_MAX_RPM
from common.link.link import OperatorLink
from common.link.session_state import Refused
from common.recording.recorder import Recorder
from common.timing.tick_age import TickAge
from common.wire.messages import TOUCH_COLUMN, Event, EventKind, ExplorationMode, Touch
from common.wire.packets import BadPacket, LinkState
from common.wire.session_messages import Answer, Heartbeat, Request
from operator_site.coupling.coupling import Places
from operator_site.devices.devices import OperatorDevices
from operator_site.devices.exoskeleton import Hand
from operator_site.safety.gated_output import GatedOutput
from operator_site.session.local_control import answer_desk
from operator_site.site import OperatorSite, session_with
from tests.robustness.hardening.strange_packets import (
    FUZZ,
    MS,
    SEQUENCES,
    able,
    details,
    event_lists,
    gaps_ms,
    integers,
    late_ms,
    materials,
    states,
    summaries,
    texts,
    touch_blocks,
    verbs,
)
from tests.virtual.kept_record import KeptRecord

pytestmark = [pytest.mark.hardening, pytest.mark.timeout(600 + SEQUENCES)]

CONFIG = OperatorConfig(
    fingers=FINGERS,
    link=OperatorLinkConfig(keys=Path("keys")),
    tacttip={finger: f"pty-{finger}" for finger in FINGERS},
    exoskeleton=CanAddress(interface="virtual"),
    engage=True,
)
SILENCE_TICKS = 150
_STROKING = np.zeros((len(FINGERS), len(TOUCH_COLUMN)), dtype=np.float32)
_STROKING[:, TOUCH_COLUMN["mode"]] = ExplorationMode.STROKING
_STROKING[:, TOUCH_COLUMN["contact"]] = 1.0
_STROKING[:, TOUCH_COLUMN["k_stroke_v"]] = 50_000.0


class FarSide:
    """The link, with what the site sent and what it will receive."""

    def __init__(self) -> None:
        self.sent: dict[str, list[bytes]] = defaultdict(list)
        self.coming: dict[str, list[bytes]] = defaultdict(list)

    def receive(self, stream: str) -> list[bytes]:
        return self.coming.pop(stream, [])

    def newest(self, stream: str) -> list[bytes]:
        return self.coming.pop(stream, [])[-1:]

    def double(self, wanted: bool) -> None:
        pass

    def send(self, stream: str, packet: bytes) -> bool:
        self.sent[stream] = [*self.sent[stream][-8:], packet]
        return True

    def send_latest(self, stream: str, packet: bytes) -> None:
        self.send(stream, packet)


@dataclass
class Devices:
    """A hand that presses, and plates that stay as they are."""

    hand: Hand = field(default_factory=Hand)
    output: GatedOutput | None = None
    pushes: bool = True
    tick: TickAge = field(default_factory=TickAge)

    def read(self, t_s: float) -> Hand:
        hand = self.hand
        hand.pose_s = hand.heights_s = t_s
        z_m = (-0.0005 + 0.0004 * math.sin(7.0 * t_s),) * len(FINGERS)
        hand.place = Places(0.1 + 0.01 * math.sin(6.0 * t_s), 0.0, z_m)
        return hand

    def missing(self) -> str:
        return ""

    def faults(self) -> list[Fault]:
        return []

    def plates(self, t_s: float) -> tuple[list[float], list[float]]:
        return [33.0] * len(FINGERS), [0.0] * len(FINGERS)

    def write(self, t_s: float, output: GatedOutput, engaged: bool) -> None:
        self.output = output

    def unconfirmed(self, since_s: float) -> dict[str, str]:
        return {}

    def figures(self) -> dict[str, object]:
        return {}


class OperatorAgainstRemote(RuleBasedStateMachine):
    """Packets and times in any order; nothing is contained, and every output is within its limits."""

    def __init__(self) -> None:
        super().__init__()
        self.far, self.devices, self.kept = FarSide(), Devices(), KeptRecord()
        self.client = session_with(cast(OperatorLink, self.far), CONFIG)
        recorder = cast(Recorder, self.kept)
        self.site = OperatorSite(CONFIG, self.client, cast(OperatorDevices, self.devices), recorder)
        self.now_ns, self.touches, self.idents = 100_000 * MS, 0, 0
        self.offset_ns = 0

    @initialize(engage=st.booleans())
    def begin(self, engage: bool) -> None:
        """Mostly both sites are engaged before the lies begin."""
        if engage:
            self.honest(20)

    @rule(ticks=st.integers(1, 12))
    def honest(self, ticks: int) -> None:
        """An honest far side for some ticks: every request granted, every heartbeat answered, touch that is fresh."""
        for _ in range(ticks):
            for packet in self.far.sent.pop("control", []):
                self.grant(Request.decode(packet))
            for packet in self.far.sent.pop("heartbeat", []):
                beat = Heartbeat.decode(packet)
                time_ns = self.now_ns + self.offset_ns
                answer = Heartbeat(beat.session, beat.sequence, time_ns, LinkState.ENGAGED, beat.sent_ns, time_ns, 0, 0)
                self.far.coming["heartbeat"].append(answer.encode())
            if self.client.session.ident:
                block = np.zeros((len(FINGERS), len(TOUCH_COLUMN)), dtype=np.float32)
                self.touch_now(LinkState.ENGAGED, block.tobytes(), ("",) * len(FINGERS), ())
            self.tick(2)

    def grant(self, request: Request) -> None:
        """Say yes."""
        given: dict[str, Any] = {}
        if request.verb == "hello":
            self.idents += 1
            given = {"session": self.idents, **able(FINGERS)}
        elif request.verb == "engage":
            given = {"max_age_s": 0.15}
        self.far.coming["control"].append(Answer(1, request.sequence, 0, "", given).encode())

    def touch_now(
        self, state: LinkState, floats: bytes, names: tuple[str, ...], happened: tuple[Event, ...], **more: Any
    ) -> None:
        """A touch of now, which the site accepts when its clock comparison allows."""
        self.touches += 1
        time_ns = max(0, self.now_ns + self.offset_ns)
        touch = Touch(self.client.session.ident, self.touches, time_ns, state, floats, names, happened, **more)
        self.far.coming["touch"].append(touch.encode())

    @rule(gap_ms=gaps_ms)
    def tick(self, gap_ms: int) -> None:
        """Let time pass; the site ticks."""
        self.now_ns = max(1_000 * MS, self.now_ns + gap_ms * MS)
        self.site.tick(self.now_ns)

    @rule(
        state=st.one_of(st.just(LinkState.ENGAGED), states),
        floats=touch_blocks,
        names=materials,
        happened=event_lists,
        said=summaries,
        skip=st.sampled_from([0, 0, 0, 1, 9_999, 20_000]),
    )
    def strange_touch(self, state: LinkState, floats: bytes, names: Any, happened: Any, said: Any, skip: int) -> None:
        """A touch that is accepted, with whatever may stand in it, and a tick."""
        timed = [
            event if late is None else event._replace(hand_ns=max(0, self.now_ns - late * MS))
            for event, late in happened
        ]
        self.touches += skip
        try:
            self.touch_now(state, floats, names, tuple(timed), summaries=said)
        except BadPacket:  # longer than a packet may be
            return
        self.tick(2)

    @rule(ident=st.integers(0, 40), finger=st.integers(0, len(FINGERS) - 1), late_ms=late_ms)
    def groove(self, ident: int, finger: int, late_ms: int) -> None:
        """A groove under a stroking finger that this packet only names; it may have to wait for its time."""
        self.touch_now(
            LinkState.ENGAGED,
            _STROKING.tobytes(),
            ("",) * len(FINGERS),
            (Event(ident, EventKind.GROOVE, finger, self.now_ns, max(0, self.now_ns - late_ms * MS), 500.0),),
        )
        self.tick(2)

    @rule(
        sent=st.one_of(st.none(), integers),
        arrived=integers,
        took=st.one_of(st.integers(0, 5 * MS), integers),
        state=states,
        offset=st.integers(-(2**62), 2**62),
        uncertainty=integers,
    )
    def strange_heartbeat(
        self, sent: int | None, arrived: int, took: int, state: LinkState, offset: int, uncertainty: int
    ) -> None:
        """An answer to a heartbeat with times of its own."""
        last = self.far.sent["heartbeat"][-1:]
        sent_ns = sent if sent is not None else Heartbeat.decode(last[0]).sent_ns if last else 0
        time_ns = min(2**63 - 1, arrived + took)
        ident = self.client.session.ident
        beat = Heartbeat(ident, 1, time_ns, state, sent_ns, arrived, offset, uncertainty)
        self.far.coming["heartbeat"].append(beat.encode())
        if arrived < 2**62 and sent is None:
            self.offset_ns = arrived - self.now_ns
        self.tick(2)

    @rule(given=details, refused=texts, latest=st.booleans(), sequence=integers, honest=st.booleans())
    def strange_answer(self, given: dict[str, Any], refused: str, latest: bool, sequence: int, honest: bool) -> None:
        """An answer to the latest request or to none, with details of any kind."""
        asked = [Request.decode(packet) for packet in self.far.sent["control"]]
        number = asked[-1].sequence if latest and asked else sequence
        if honest:
            given = {**able(FINGERS), "session": 7, "max_age_s": 0.15, **given}
        try:
            packet = Answer(self.client.session.ident, number, 0, refused if not latest else "", given).encode()
        except BadPacket:
            return
        self.far.coming["control"].append(packet)
        self.tick(2)

    @rule(verb=verbs, given=details)
    def person(self, verb: str, given: dict[str, Any]) -> None:
        """The person at the desk asks for something."""
        with suppress(Refused):
            answer_desk(self.client, self.site.attendance, self.site.coupling, self.now_ns, "", verb, given)
        self.tick(2)

    @rule()
    def status(self) -> None:
        """Status file and console get the figures."""
        self.site.publish(self.now_ns, self.site.figures())

    @invariant()
    def nothing_is_contained(self) -> None:
        assert self.site.contain.count == 0, dict(self.site.contain.latest)

    @precondition(lambda self: self.devices.output is not None)
    @invariant()
    def outputs_are_within_limits(self) -> None:
        output = self.devices.output
        assert output is not None
        assert all(0.0 <= force_n <= FINGER_FORCE_N for force_n in output.force_n)
        assert all(0.0 <= rpm <= MOTOR_MAX_RPM for rpm in output.motor_rpm)
        assert all(-1.0 <= drive <= 1.0 for drive in output.peltier_drive)

    def teardown(self) -> None:
        """Silence: every output is neutral in the end."""
        for _ in range(SILENCE_TICKS):
            self.now_ns += 2 * MS
            self.site.tick(self.now_ns)
        self.nothing_is_contained()
        output = self.devices.output
        assert output is not None
        assert output.force_n == output.motor_rpm == output.peltier_drive == [0.0] * len(FINGERS)


OperatorAgainstRemote.TestCase.settings = FUZZ
TestOperatorAgainstRemote = OperatorAgainstRemote.TestCase
