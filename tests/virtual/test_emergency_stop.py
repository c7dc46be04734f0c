"""Emergency stops in full work: the answers of both sites, and the outputs of the simulated devices."""

from dataclasses import dataclass, field
from pathlib import Path

import msgpack
import numpy as np
import pytest
from mcap.reader import make_reader
from numpy.typing import NDArray

from common.limits import (
    FINGER_FORCE_N,
    FORCE_RAMP_UP_N_S,
    FORCE_SAFE_S,
    GAP_S,
    MOTOR_FLOOR_RPM,
    MOTOR_SAFE_S,
    MOTOR_STILL_S,
    THERMAL_SAFE_S,
)
from common.link.session_state import Refused
from common.timing.timeouts import RETREAT_AFTER_S
from remote_site.safety.setpoints import CLEAR_HEIGHT_M, HEIGHT_LOW_M, RETREAT_M_S
from robustness.fault_judge import HAND_STOP_S
from robustness.fault_table import FREE, STROKING
from robustness.virtual_fault_session import VirtualFaultSession
from tests.system.truth import FELT_N, HEATS, STROKES, Floats, Truth, between, read_truth

pytestmark = pytest.mark.long

AT_OPERATOR, AT_REMOTE = "emergency stop by the operator", "emergency stop at the remote site"
LEFT_ALONE_S = 2.0
LATE_S = 0.016
"""Added to a hold time: an entry of the recording every 10 ms, and a tick of each site."""
STILL_M = 0.0005
ROUNDING_N = 1e-9
CLEAR_S = GAP_S + RETREAT_AFTER_S + (CLEAR_HEIGHT_M - HEIGHT_LOW_M) / RETREAT_M_S
"""From the deepest that a finger can be, until it is clear of everything."""
COMES_S = 4.0
"""From engaging until the remote hand has come to the operator's and its fingers are down, with some to spare."""
CONFIRMED_S = 2.0


@dataclass(slots=True)
class Stop:
    """One emergency stop, what both sites said at once and later, and what was refused by then; times in s."""

    begun_s: float
    outcome: str
    at_once: dict[str, str]
    later: dict[str, str] = field(default_factory=dict)
    refused: list[str] = field(default_factory=list)
    cleared_s: float = 0.0
    engaged_s: float = 0.0


@dataclass(frozen=True, slots=True)
class Sent:
    """Each tick of the operator's site: when (n,), s, whether both sites were engaged (n,), and forces (n, 5), N."""

    time_s: Floats
    engaged: NDArray[np.bool_]
    force_n: Floats

    @classmethod
    def read(cls, path: Path) -> "Sent":
        with path.open("rb") as file:
            rows = [
                (message.log_time * 1e-9, *msgpack.unpackb(message.data))
                for _, _, message in make_reader(file).iter_messages(topics=["operator/rendered"])
            ]
        return cls(
            np.array([row[0] for row in rows]), np.array([row[1] for row in rows]), np.array([row[3] for row in rows])
        )


@dataclass(frozen=True, slots=True)
class Story:
    """The stops of one session by name, what really happened, and what the operator's site sent."""

    stops: dict[str, Stop]
    truth: Truth
    sent: Sent

    def latched_s(self, name: str) -> float:
        """When the site where a stop was asked for latched it."""
        words = AT_REMOTE if name == "remote" else AT_OPERATOR
        begun_s = self.stops[name].begun_s
        return next(t for t, fault in self.truth.faults if begun_s <= t <= begun_s + CONFIRMED_S and fault == words)


def refusal(session: VirtualFaultSession, site: str, verb: str) -> str:
    """What a desk says that will not; empty where it will."""
    try:
        session.ask(site, verb)
    except Refused as refused:
        return str(refused)
    return ""


def stop(session: VirtualFaultSession, site: str) -> Stop:
    """Ask for an emergency stop, and wait for what the devices say of it."""
    begun_s = session.now_s()
    session.ask(site, "estop")
    while not (outcome := session.ask(site, "status")["estop"]):
        assert session.now_s() < begun_s + CONFIRMED_S, "nothing is said of the stop"
    return Stop(begun_s, outcome, session.states())


def clear_refusal(session: VirtualFaultSession, site: str) -> str:
    """Ask for the latched fault to be cleared, and return what the far site says; empty when it is cleared."""
    session.ask(site, "clear_fault")
    end_s = session.now_s() + 2.0
    while session.now_s() < end_s:
        status = session.ask(site, "status")
        if not status["fault"] and not status.get("remote_fault"):
            return ""
        if status.get("remote_fault") and status.get("refusal"):
            return str(status["refusal"])
    return "still latched"


@pytest.fixture(scope="module")
def story(tmp_path_factory: pytest.TempPathFactory) -> Story:
    """A session that was stopped from either desk, and with a module at either site that does not confirm."""
    folder, stops = tmp_path_factory.mktemp("stopped"), {}
    with VirtualFaultSession.open(folder) as session:
        session.wait_until_working()
        stops["operator"] = at_operator = stop(session, "operator")
        session.wait(LEFT_ALONE_S)
        at_operator.refused = [refusal(session, "operator", "engage")]
        at_operator.later = session.states()
        at_operator.cleared_s = session.now_s()
        assert clear_refusal(session, "operator") == ""
        at_operator.engaged_s = session.now_s()
        session.ask("operator", "engage")

        session.wait_until_working()
        stops["remote"] = at_remote = stop(session, "remote")
        session.wait(LEFT_ALONE_S)
        at_remote.refused = [
            clear_refusal(session, "operator"),
            refusal(session, "operator", "engage"),
            refusal(session, "remote", "engage"),
        ]
        at_remote.later = session.states()
        at_remote.cleared_s = session.now_s()
        session.ask("remote", "clear_fault")
        while session.ask("operator", "status")["remote_fault"]:
            assert session.now_s() < at_remote.cleared_s + 5.0, "the operator's site does not hear of it"
        at_remote.engaged_s = session.now_s()
        session.ask("operator", "engage")

        for name, simulation, fault in (
            ("stuck", "sim-operator", f"stuck {STROKING} 300"),
            ("silent", "sim-remote", f"silence {FREE} thermal"),
        ):
            session.wait_until_working()
            session.command(simulation, fault)
            stops[name] = stop(session, "operator")
            session.command(simulation, "mend")
            session.clear_and_engage()
        session.wait_until_working()
    return Story(stops, read_truth(folder), Sent.read(folder / "operator.mcap"))


@pytest.mark.parametrize(("name", "devices_of_sites"), [("operator", 2), ("remote", 1)])
def test_every_device_confirms(name: str, devices_of_sites: int, story: Story) -> None:
    outcome = story.stops[name].outcome
    assert outcome.count("confirmed by every device") == devices_of_sites, outcome


@pytest.mark.parametrize("name", ["operator", "remote"])
def test_outputs_are_off_within_the_hold_times_and_stay_off(name: str, story: Story) -> None:
    truth, latched_s, cleared_s = story.truth, story.latched_s(name), story.stops[name].cleared_s
    assert cleared_s - latched_s > LEFT_ALONE_S
    for time_s, output, hold_s in (
        (truth.finger_s, truth.force_n[:, STROKES], FORCE_SAFE_S),
        (truth.finger_s, truth.motor_mv[:, STROKES], MOTOR_SAFE_S),
        (truth.finger_s, truth.peltier[:, STROKES], THERMAL_SAFE_S),
        (truth.patient_s, truth.heater[:, HEATS], THERMAL_SAFE_S),
    ):
        assert between(time_s, output, latched_s - 0.5, latched_s).any(), "it must act before"
        assert not between(time_s, output, latched_s + hold_s + LATE_S, cleared_s).any()
    safe_s = latched_s + THERMAL_SAFE_S + LATE_S
    for time_s, outputs in (
        (truth.finger_s, np.hstack((truth.force_n, truth.motor_mv, truth.peltier))),
        (truth.patient_s, truth.heater),
    ):
        assert not between(time_s, outputs, safe_s, cleared_s).any(), "on any finger"
    still_s = latched_s + MOTOR_STILL_S + LATE_S
    assert between(truth.finger_s, truth.motor_rpm, still_s, cleared_s).max() < MOTOR_FLOOR_RPM


@pytest.mark.parametrize("name", ["operator", "remote"])
def test_the_remote_hand_stops_and_retreats(name: str, story: Story) -> None:
    truth, latched_s, cleared_s = story.truth, story.latched_s(name), story.stops[name].cleared_s
    strokes_m = between(truth.patient_s, truth.hand_x_m, latched_s - 0.5, latched_s)
    assert np.ptp(strokes_m) > 10.0 * STILL_M, "it must move before"
    assert np.ptp(between(truth.patient_s, truth.hand_x_m, latched_s + HAND_STOP_S, cleared_s)) < STILL_M
    pressing_m = between(truth.patient_s, truth.hand_z_m, latched_s - 0.5, latched_s)[:, STROKES]
    assert pressing_m.max() < CLEAR_HEIGHT_M - STILL_M, "it must be down before"
    retreated_m = between(truth.patient_s, truth.hand_z_m, latched_s + CLEAR_S, cleared_s)
    assert retreated_m[:, [HEATS, STROKES]].min() > CLEAR_HEIGHT_M - STILL_M


def test_a_stop_by_the_operator_latches_both_sites_until_it_is_cleared(story: Story) -> None:
    stop = story.stops["operator"]
    latched = dict.fromkeys(("remote", "operator"), f"fault: {AT_OPERATOR}")
    assert stop.at_once == stop.later == latched
    assert stop.refused == [f"a fault is latched ({AT_OPERATOR}): clear it first"]


def test_a_stop_of_the_remote_site_cannot_be_cleared_by_the_operator(story: Story) -> None:
    stop = story.stops["remote"]
    assert stop.at_once["remote"] == stop.later["remote"] == f"fault: {AT_REMOTE}"
    assert not stop.at_once["operator"].startswith("engaged")
    clear, engage, engage_there = stop.refused
    assert clear == f"{AT_REMOTE}: to be cleared where it was latched"
    assert f"a fault is latched ({AT_REMOTE})" in engage
    assert "only the operator site can do this" in engage_there


@pytest.mark.parametrize("name", ["operator", "remote"])
def test_force_returns_after_engaging_once_the_remote_hand_has_arrived(name: str, story: Story) -> None:
    stop, truth, sent = story.stops[name], story.truth, story.sent
    begun_s = stop.engaged_s
    assert not between(truth.finger_s, truth.force_n, stop.cleared_s, begun_s + LATE_S).any(), "clearing moves nothing"
    assert between(truth.finger_s, truth.force_n[:, STROKES], begun_s, begun_s + COMES_S).max() > FELT_N
    first = int(np.flatnonzero((sent.time_s > begun_s) & sent.engaged)[0])
    assert not sent.engaged[first - 1]
    assert not sent.force_n[first - 1].any()
    since_s = sent.time_s[first:] - sent.time_s[first - 1]
    ramping = since_s < FINGER_FORCE_N / FORCE_RAMP_UP_N_S
    force_n = sent.force_n[first:][ramping]
    assert (force_n <= FORCE_RAMP_UP_N_S * since_s[ramping, np.newaxis] + ROUNDING_N).all()


@pytest.mark.parametrize(
    ("name", "silent", "confirmed"),
    [("stuck", f"{STROKING} tacttip", "remote site"), ("silent", f"{FREE} thermal_sensor", "here")],
)
def test_an_unconfirmed_module_of_either_site_is_named(name: str, silent: str, confirmed: str, story: Story) -> None:
    stop = story.stops[name]
    here, _, there = stop.outcome.removeprefix("here: ").partition("; remote site: ")
    confirms, named = (here, there) if confirmed == "here" else (there, here)
    assert "stopped, confirmed by every device" in confirms
    assert "not confirmed" in named
    assert silent in named
    assert stop.at_once["remote"] == f"fault: {AT_OPERATOR}"
    assert stop.at_once["operator"].startswith("fault: ")  # a stuck drive may have been found by itself before
