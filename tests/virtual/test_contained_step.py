"""A step of a site's tick that raises: neutral within the hold times, a fault with its place, and work resumes."""

from collections.abc import Callable
from typing import Any

import pytest

from common.faults.fault import FaultCode
from common.limits import FORCE_SAFE_S, GAP_S, THERMAL_SAFE_S
from common.wire.packets import LinkState
from operator_site.site_recording import SiteRecording
from tests.conftest import Contained
from tests.virtual.judge import REMOTE_LATE_S, SERVO_S, STILL_M, Latches, check_operator_safe
from tests.virtual.kept_record import KeptRecord
from tests.virtual.session import TICK_S, VirtualSession

pytestmark = pytest.mark.long

PLACES: dict[str, Callable[[VirtualSession], tuple[object, str]]] = {
    "operator read": lambda session: (session.operator._devices, "read"),
    "operator session": lambda session: (session.operator.client.link, "newest"),
    "operator motion": lambda session: (session.operator, "_send_motion"),
    "operator render": lambda session: (session.operator.rendering.fingertips, "step"),
    "operator gate": lambda session: (session.operator.rendering._gate, "_forces"),
    "operator write": lambda session: (session.operator._devices, "write"),
    "remote read": lambda session: (session.remote._devices, "read"),
    "remote session": lambda session: (session.remote.server.link, "newest_of_each"),
    "remote identify": lambda session: (session.remote.perception, "_share"),
    "remote heat": lambda session: (session.remote.heating, "step"),
    "remote gate": lambda session: (session.remote.gate, "_watch_forces"),
    "remote write": lambda session: (session.remote._devices, "write"),
    "remote follow": lambda session: (session.remote, "_places"),
    "remote touch": lambda session: (session.remote.perception, "packet"),
}
"""Step and what of it is made to raise."""


class Failing:
    """Stands in the place of an attribute and raises."""

    def __init__(self, thing: object, name: str) -> None:
        self._thing: Any = getattr(thing, name)
        self.times = 0

    def __call__(self, *given: Any, **named: Any) -> Any:
        self.times += 1
        raise ValueError("as the test says\nERROR forged")


@pytest.fixture
def fail(monkeypatch: pytest.MonkeyPatch) -> Callable[[object, str], Failing]:
    """Makes an attribute raise until the patch is undone."""

    def make(thing: object, name: str) -> Failing:
        failing = Failing(thing, name)
        monkeypatch.setattr(thing, name, failing)
        return failing

    return make


@pytest.mark.parametrize("place", PLACES)
def test_a_step_that_raises_is_neutral_and_named_at_both_sites_and_work_resumes_after_a_clear(
    working: VirtualSession,
    fail: Callable[[object, str], Failing],
    monkeypatch: pytest.MonkeyPatch,
    contained: Contained,
    place: str,
) -> None:
    side, step = place.split()
    if place == "operator write":  # from when the devices hear nothing, which is not when the fault latches
        working.watch = [check for check in working.watch if not isinstance(check, Latches)]
    fail(*PLACES[place](working))
    began_s = working.time_s
    remote, operator = working.remote.server.session, working.operator.client.session
    failed, other = (operator, remote) if side == "operator" else (remote, operator)
    for now in working.run(0.5):
        check_operator_safe(now, now.time_s - began_s)
        assert now.time_s - began_s <= THERMAL_SAFE_S + REMOTE_LATE_S or now.heater == 0.0, now
    assert failed.state is LinkState.FAULT
    assert failed.fault is not None
    assert failed.fault.code is FaultCode.CONTAINED
    assert failed.fault.detail.startswith(f"{step}: ValueError in test_contained_step.py:")
    assert failed.fault.detail.isprintable()
    assert not working.both_engaged
    stood = working.now
    for now in working.run(0.3):
        assert abs(now.x_m - stood.x_m) <= STILL_M, now
        assert now.z_m >= stood.z_m - STILL_M, now
    assert contained.take() == [failed.fault.detail]
    if place == "remote identify":
        assert working.operator.client.remote_fault == failed.fault, "the operator's site knows the same"

    working.run_coarsely(1.0)
    assert other.state is not LinkState.ENGAGED
    monkeypatch.undo()
    working.run_coarsely(0.5)
    working.clear_faults()
    working.run_coarsely(0.5)
    if working.remote.server.session.state is LinkState.FAULT:
        working.clear_faults()
        working.run_coarsely(0.5)
    working.engage()
    working.resume()


@pytest.mark.parametrize("stream", ["operator/input", "operator/session", "operator/rendered"])
def test_a_recording_that_raises_is_named_and_the_work_continues(
    working: VirtualSession, contained: Contained, stream: str
) -> None:
    class Broken(KeptRecord):
        def write(self, stream_now: str, time_ns: int, payload: bytes) -> None:
            if stream_now == stream:
                raise OSError("no space left")
            super().write(stream_now, time_ns, payload)

    broken: Any = Broken()
    working.operator._recording = SiteRecording(broken)
    if stream == "operator/session":
        working.operator.client.session.note("note", "something happened")
    working.run(0.2)
    assert working.at_work
    assert str(working.operator.figures()["recording_failed"]).startswith("record: OSError in ")
    assert len(contained.take()) == 1


def test_outputs_are_neutral_from_an_exception_of_a_gate_until_a_person_engages(
    working: VirtualSession,
    fail: Callable[[object, str], Failing],
    monkeypatch: pytest.MonkeyPatch,
    contained: Contained,
) -> None:
    written: list[Any] = []
    write = working.operator._devices.write

    def keep(now_s: float, output: Any, engaged: bool) -> None:
        written.append(output)
        write(now_s, output, engaged)

    working.operator._devices.write = keep  # type: ignore[method-assign]
    fail(*PLACES["operator gate"](working))
    working.run(2 * TICK_S)
    monkeypatch.undo()
    working.clear_faults()
    working.run(1.0)
    assert len(written) == round(1.0 / TICK_S) + 2
    for output in written:
        assert output.force_n == output.motor_rpm == output.peltier_drive == [0.0] * 5
    contained.take()


def test_a_remote_gate_that_raises_releases_the_telemanipulator_at_once(
    working: VirtualSession, fail: Callable[[object, str], Failing], contained: Contained
) -> None:
    fail(*PLACES["remote gate"](working))
    stood = working.run(SERVO_S)[-1]
    for now in working.run(0.2):
        assert now.heater == 0.0
        assert abs(now.x_m - stood.x_m) <= STILL_M, now
        assert now.z_m >= stood.z_m - STILL_M, now
    assert working.remote._command.released
    assert FORCE_SAFE_S > GAP_S
    contained.take()
