import pytest
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from common.packets import LinkState
from common.session import Refused, Session


class Sessions(RuleBasedStateMachine):
    """Whatever happens in whatever order: never engaged without a far side or with a fault."""

    def __init__(self) -> None:
        super().__init__()
        self.session = Session()
        self.far_side = 0
        self.fault = ""
        self.asked = False

    @rule(ident=st.integers(1, 2**62))
    def connect(self, ident: int) -> None:
        self.session.connect(ident)
        self.far_side, self.asked = ident, False

    @rule(ident=st.integers(-5, 0))
    def connect_as_nobody(self, ident: int) -> None:
        with pytest.raises(ValueError, match="not positive"):
            self.session.connect(ident)

    @rule()
    def disconnect(self) -> None:
        self.session.disconnect()
        self.far_side, self.asked = 0, False

    @rule()
    def engage(self) -> None:
        if self.fault or not self.far_side:
            with pytest.raises(Refused, match=self.fault or "hello"):
                self.session.engage()
        else:
            self.session.engage()
            self.asked = True

    @rule()
    def disengage(self) -> None:
        self.session.disengage()
        self.asked = False

    @rule(why=st.sampled_from(["hot plate", "emergency stop"]))
    def latch(self, why: str) -> None:
        self.session.latch(why)
        self.fault, self.asked = self.fault or why, False

    @rule()
    def clear(self) -> None:
        if self.fault:
            self.session.clear()
            self.fault = ""
        else:
            with pytest.raises(Refused, match="no fault"):
                self.session.clear()

    @invariant()
    def agrees(self) -> None:
        session = self.session
        assert session.engaged == self.asked
        assert session.ident == self.far_side
        assert session.fault == self.fault
        assert (session.state is LinkState.FAULT) == bool(self.fault)
        if not self.fault:
            assert (session.state is LinkState.DISCONNECTED) == (not self.far_side)


TestSessions = Sessions.TestCase


def test_after_a_fault_somebody_new_can_connect_and_clear_it() -> None:
    session = Session()
    session.connect(1)
    session.latch("hot plate")
    session.disconnect()
    assert session.ident == 0
    session.connect(2)
    assert session.state is LinkState.FAULT
    session.clear()
    assert session.state is LinkState.CONNECTED
