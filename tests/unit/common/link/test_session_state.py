import logging
import re

import msgpack
import pytest
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from common.faults.fault import OF_THE_PATIENT, Fault, FaultCode
from common.faults.texts import fault_text
from common.link.session_state import Happening, Refused, Session
from common.wire.packets import LinkState

HOT = Fault(FaultCode.PLATE_TOO_HOT, "index", value=43.0, limit=42.0)


class Sessions(RuleBasedStateMachine):
    """For events in any order: never engaged without a peer or with a fault, and every event is recorded."""

    def __init__(self) -> None:
        super().__init__()
        self.session = Session()
        self.far_side = 0
        self.fault: Fault | None = None
        self.here_only = False
        self.asked = self.silent = False
        self.missing = ""
        self.happened: list[tuple[str, int, str | Fault]] = []

    @rule(ident=st.integers(1, 2**62), text=st.sampled_from(["", "operator curve:abc"]))
    def connect(self, ident: int, text: str) -> None:
        self.session.connect(ident, text)
        self.far_side, self.asked, self.missing = ident, False, ""
        self.happened.append(("connected", ident, text))

    @rule(ident=st.integers(-5, 0))
    def connect_as_nobody(self, ident: int) -> None:
        with pytest.raises(ValueError, match="not positive"):
            self.session.connect(ident)

    @rule(why=st.sampled_from(["", "the far side is silent"]), left=st.booleans())
    def disconnect(self, why: str, left: bool) -> None:
        if self.far_side:
            self.happened.append(("left" if left else "disconnected", self.far_side, why))
        self.session.disconnect(why, left=left)
        self.far_side, self.asked = 0, False

    @rule()
    def engage(self) -> None:
        if self.fault or not self.far_side:
            with pytest.raises(Refused, match=fault_text(self.fault) or "hello"):
                self.session.engage()
            return
        if not self.asked:
            self.happened.append(("engaged", self.far_side, "150 ms"))
        self.session.engage("150 ms")
        self.asked = True

    @rule()
    def disengage(self) -> None:
        if self.asked:
            self.happened.append(("disengaged", self.far_side, "asked for"))
        self.session.disengage("asked for")
        self.asked = False

    @rule(fault=st.sampled_from([HOT, Fault(FaultCode.OPERATOR_STOP)]), here_only=st.booleans())
    def latch(self, fault: Fault, here_only: bool) -> None:
        if not self.fault:
            self.happened.append(("fault", self.far_side, fault))
        self.session.latch(fault, cleared_here_only=here_only)
        self.fault, self.asked = self.fault or fault, False
        self.here_only = self.here_only or here_only

    @rule(here=st.booleans())
    def clear(self, here: bool) -> None:
        if not self.fault:
            with pytest.raises(Refused, match="no fault"):
                self.session.clear(here=here)
        elif self.here_only and not here:
            with pytest.raises(
                Refused, match=f"{re.escape(fault_text(self.fault))}: to be cleared where it was latched"
            ):
                self.session.clear(here=here)
        else:
            self.happened.append(("cleared", self.far_side, self.fault))
            self.session.clear(here=here)
            self.fault, self.here_only = None, False

    @rule(gap_ms=st.one_of(st.none(), st.sampled_from([-1, 0, 100, 101])))
    def hear(self, gap_ms: int | None) -> None:
        silent = gap_ms is None or not 0 <= gap_ms <= 100
        if silent and not self.silent and self.asked and gap_ms is not None:
            self.silent = True
            self.happened.append(("silent", self.far_side, "no motion for 100 ms"))
        elif not silent and self.silent:
            self.silent = False
            self.happened.append(("heard", self.far_side, "motion again"))
        self.session.heard(None if gap_ms is None else gap_ms * 1_000_000, 0.1, "motion")

    @rule(missing=st.sampled_from(["", "exoskeleton: opening", "index tacttip: opening"]))
    def equip(self, missing: str) -> None:
        if self.far_side and missing != self.missing:
            self.missing = missing
            self.happened.append(("missing" if missing else "complete", self.far_side, missing))
        self.session.equipped(missing)

    @rule()
    def record(self) -> None:
        events = [
            (happening.what, happening.session, happening.fault or happening.text)
            for happening in self.session.take_happenings()
        ]
        assert events == self.happened
        assert self.session.take_happenings() == []
        self.happened.clear()

    @invariant()
    def agrees(self) -> None:
        session = self.session
        assert session.engaged == self.asked
        assert session.ident == self.far_side
        assert session.fault == self.fault
        assert session.cleared_here_only == self.here_only
        assert (session.state is LinkState.FAULT) == bool(self.fault)
        if not self.fault:
            assert (session.state is LinkState.DISCONNECTED) == (not self.far_side)


TestSessions = Sessions.TestCase


def test_an_event_is_recorded_with_its_session() -> None:
    session = Session()
    session.connect(7, "operator curve:abc")
    session.note("estop", "confirmed by every device")
    first, second = session.take_happenings()
    assert first == Happening("connected", 7, "operator curve:abc", None)
    assert msgpack.unpackb(first.pack()) == ["connected", 7, "operator curve:abc", None]
    assert msgpack.unpackb(second.pack()) == ["estop", 7, "confirmed by every device", None]


def test_a_missing_device_is_noted_in_each_session_and_its_return_only_where_it_was_missing() -> None:
    session = Session()
    for ident in (1, 2):
        session.connect(ident)
        session.equipped("index tacttip")
        session.disconnect()
        session.equipped("index tacttip")
    session.connect(3)
    session.equipped("")
    noted = [(each.session, each.what) for each in session.take_happenings() if each.what in ("missing", "complete")]
    assert noted == [(1, "missing"), (2, "missing")]


def test_faults_and_stops_stand_out_in_the_log(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO)
    session = Session()
    session.connect(7)
    session.engage("150 ms")
    session.latch(HOT)
    session.note("estop", "confirmed")
    levels = {record.getMessage(): record.levelno for record in caplog.records}
    assert levels == {
        "connected": logging.INFO,
        "engaged: 150 ms": logging.INFO,
        "fault: index: plate at 43.0 C, above 42.0 C": logging.WARNING,
        "estop: confirmed": logging.WARNING,
    }


def test_a_press_takes_the_place_of_a_failed_switch_and_is_a_persons_stop() -> None:
    session = Session()
    for code in (FaultCode.PATIENT_SWITCH_FAILED, FaultCode.PATIENT_STOP, FaultCode.PATIENT_SWITCH_FAILED):
        session.latch(Fault(code))
    assert session.fault == Fault(FaultCode.PATIENT_STOP)
    assert session.stop is FaultCode.PATIENT_STOP


@pytest.mark.parametrize("code", OF_THE_PATIENT)
def test_the_patients_stop_takes_the_place_of_another_fault_and_is_cleared_here_only(code: FaultCode) -> None:
    session, stop = Session(), Fault(code, detail="is silent")
    session.latch(HOT)
    session.latch(stop)
    session.latch(HOT)
    assert session.fault == stop
    with pytest.raises(Refused, match="to be cleared where it was latched"):
        session.clear(here=False)
    session.clear()
    assert session.state is LinkState.DISCONNECTED
    assert [happening.fault for happening in session.take_happenings()] == [HOT, stop, stop]


def test_a_persons_stop_is_known_until_it_is_cleared_whatever_was_latched_before_it() -> None:
    session = Session()
    session.latch(HOT)
    assert session.stop is None
    for code in (FaultCode.OPERATOR_STOP, FaultCode.PATIENT_STOP, FaultCode.REMOTE_STOP):
        session.latch(Fault(code))
    assert session.stop is FaultCode.PATIENT_STOP
    session.clear()
    assert session.stop is None
