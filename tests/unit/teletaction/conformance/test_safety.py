"""An examination drives only with permission, stops beyond the announced motion, and ends neutral."""

from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any

import can
import pytest

from common.buses.can_frames import packing
from common.buses.can_port import CanAddress
from common.buses.serial_messages import FrameReader, HeaterCommand, MessageId, TactTipCommand
from common.buses.serial_port import DeviceAbsent
from common.fingers import FINGERS
from sim_sensors.devices.exoskeleton import Exoskeleton
from sim_sensors.devices.tacttip import TactTip
from sim_sensors.devices.telemanipulator import Telemanipulator
from sim_sensors.devices.texture_sensor import TextureSensor
from sim_sensors.devices.thermal_sensor import ThermalSensor
from teletaction.conformance.checklist import Duty, How, NotApplicable, Outcome, Tried, Verdict
from teletaction.conformance.drives import Drives
from teletaction.conformance.examination import OnTrial
from teletaction.conformance.module_talk import ModuleTalk
from teletaction.conformance.node_talk import KINDS, BusEnd, NodeName, NodeTalk, name_of
from tests.unit.teletaction.conformance.examining import ALL, examined, on_trial
from tests.unit.teletaction.conformance.spoiled_module import BORN_S, changed_reports, over
from tests.unit.teletaction.conformance.spoiled_node import changed_states, going
from tests.unit.teletaction.conformance.virtual_ends import VirtualModule, VirtualNode, values_of
from tests.unit.teletaction.conformance.wrong_drives import reversed_polarity

LISTENING = frozenset({How.LISTEN})
POINTS = 4


def commands(end: VirtualModule) -> list[HeaterCommand | TactTipCommand]:
    """The good commands of its own kind that a module was sent."""
    message_id, kind = {
        ThermalSensor: (MessageId.HEATER_COMMAND, HeaterCommand),
        TactTip: (MessageId.TACTTIP_COMMAND, TactTipCommand),
    }.get(type(end.module), (None, None))
    found = []
    for frame in FrameReader().feed(b"".join(end.said)):
        if kind is not None and frame.message_id == message_id:
            with suppress(ValueError):
                found.append(kind.decode(frame.payload))
    return found


@pytest.mark.parametrize("kind", [ThermalSensor, TactTip, TextureSensor])
def test_a_module_gets_no_command_without_permission(kind: Callable[..., Any]) -> None:
    end = VirtualModule(kind(1, BORN_S))
    results = examined(end, LISTENING)
    assert commands(end) == []
    tried = {t.duty.number for t in results if t.verdict is not Verdict.NOT_TRIED}
    assert tried == {t.duty.number for t in results if t.duty.how is How.LISTEN}


@pytest.mark.parametrize("node", [Exoskeleton(), Telemanipulator()])
def test_a_node_gets_no_frame_without_permission(node: Any) -> None:
    end = VirtualNode(node)
    examined(end, LISTENING)
    assert end.said == []


def test_no_plate_comes_near_its_limit_without_permission_to_heat() -> None:
    end = VirtualModule(ThermalSensor(1, BORN_S))
    warmest_c = 0.0

    def step(below: Callable[[float], None], drive: float) -> None:
        nonlocal warmest_c
        below(drive)
        warmest_c = max(warmest_c, end.plate.plate_c)

    over(end.plate, "step", step)
    examined(end, frozenset({How.LISTEN, How.EXERCISE}))
    assert 24.0 < warmest_c < 26.0


def interrupted(end: VirtualModule | VirtualNode, share: float, steps: int) -> None:
    trial = on_trial(end)
    end.interrupt_at = end.steps + max(1, round(share * steps))
    with pytest.raises(KeyboardInterrupt):
        trial.tried(ALL, lambda _: None)


@pytest.mark.parametrize("kind", [ThermalSensor, TactTip])
def test_a_module_is_left_neutral_wherever_the_examination_is_interrupted(kind: Callable[..., Any]) -> None:
    whole = VirtualModule(kind(1, BORN_S))
    examined(whole)
    off = TactTipCommand(0, 0) if kind is TactTip else HeaterCommand(0)
    driving = 0
    for point in range(POINTS):
        end = VirtualModule(kind(1, BORN_S))
        # A prime share of the steps, so that no two stops are in the same place of a trial.
        interrupted(end, 0.35 + 0.16 * point, whole.steps)
        sent = commands(end)
        assert sent[-1] == off
        driving += off not in sent[-3:-2]
    assert driving, "none of the interruptions came while something was driven"


@pytest.mark.long
@pytest.mark.parametrize("kind", [Exoskeleton, Telemanipulator])
def test_a_node_is_left_neutral_wherever_the_examination_is_interrupted(kind: Callable[[], Any]) -> None:
    whole = VirtualNode(kind())
    examined(whole)
    for point in range(POINTS):
        end = VirtualNode(kind())
        interrupted(end, 0.13 + 0.231 * point, whole.steps)
        assert neutral(end.said[-1])


def neutral(frame: can.Message) -> bool:
    if frame.arbitration_id == packing("FingerForces").frame_id:
        return set(values_of(frame, "FingerForces").values()) == {0.0}
    return values_of(frame, "HeightSetpoint")["released"] == 1.0


def stopped(results: list[Tried], words: str) -> None:
    """That nothing was tried after the duty that stopped it."""
    at = next(n for n, tried in enumerate(results) if words in tried.came)
    assert results[at].verdict is Verdict.FAIL
    assert {tried.verdict for tried in results[at + 1 :]} <= {Verdict.NOT_TRIED}
    assert all(tried.verdict is not Verdict.FAIL for tried in results[:at])


@pytest.mark.parametrize("polarity", [30.0, -30.0])
def test_a_plate_that_runs_away_stops_everything(polarity: float) -> None:
    end = VirtualModule(ThermalSensor(1, BORN_S))
    end.polarity = polarity
    results = examined(end)
    stopped(results, "the plate is at")
    assert commands(end)[-1] == HeaterCommand(0)


def test_a_plate_that_can_no_longer_be_read_stops_everything() -> None:
    end = VirtualModule(TactTip(1, BORN_S))

    def unreadable(payload: bytearray, _: int) -> None:
        if end.module._watchdog.limit_s and end.plate.plate_c > 23.5:  # type: ignore[attr-defined]
            payload += b"?"

    changed_reports(end.module, unreadable)
    stopped(examined(end), "unreadable reports")
    assert commands(end)[-1] == TactTipCommand(0, 0)


def test_a_plate_without_reports_is_not_heated() -> None:
    end = VirtualModule(TactTip(1, BORN_S))
    over(end.module, "_say", lambda below, *said: None if end.plate.plate_c > 30.0 else below(*said))
    stopped(examined(end), "no reports while it is heated")
    assert end.plate.plate_c < 34.0
    assert commands(end)[-1] == TactTipCommand(0, 0)


def test_a_plate_that_is_driven_the_wrong_way_is_not_frozen() -> None:
    end = reversed_polarity()
    examined(end)
    assert end.plate.plate_c > 18.0


def test_a_plate_that_is_hot_already_is_not_driven() -> None:
    end = VirtualModule(ThermalSensor(1, BORN_S))
    end.plate.plate_c = 55.0
    over(end.plate, "step", lambda below, drive: None)
    results = examined(end)
    obeys = next(tried for tried in results if tried.duty.number == "D4")
    assert obeys.verdict is Verdict.NOT_APPLICABLE
    assert "nothing is driven" in obeys.came


def test_an_exoskeleton_that_pushes_harder_stops_everything() -> None:
    end = changed_states(VirtualNode(Exoskeleton()), lambda values: {**values, "ring": 10.0 * values["ring"]})
    results = examined(end)
    stopped(results, "it pushes with 3.00 N")
    assert neutral(end.said[-1])


def test_a_telemanipulator_that_runs_away_stops_everything() -> None:
    end = going(lambda node, hand, x_m, y_m, z_m: (x_m + (0.02 if node._hand_alive else 0.0), y_m, z_m))
    results = examined(end)
    stopped(results, "mm from where it stood")
    assert neutral(end.said[-1])


def test_a_finger_in_contact_stops_everything() -> None:
    end = VirtualNode(Telemanipulator())

    def measure(below: Callable[..., None], x_m: float, y_m: float, z_m: Any, force_n: Any) -> None:
        below(x_m, y_m, z_m, force_n + (1.5 if z_m.max() > 0.0065 else 0.0))

    over(end.node, "measure", measure)
    results = examined(end)
    stopped(results, "a finger meets something with 1.50 N")
    assert neutral(end.said[-1])


def test_a_finger_is_not_asked_to_jump() -> None:
    end = VirtualNode(Telemanipulator())
    ahead_mm: list[float] = []

    def send(below: Callable[[can.Message], None], message: can.Message) -> None:
        values = values_of(message, "HeightSetpoint") if message.arbitration_id == 0x201 else {"released": 1.0}
        if values["released"] == 0.0:
            ahead_mm.extend(abs(values[finger] - 1e3 * z_m) for finger, z_m in zip(FINGERS, end.hand.z_m, strict=True))
        below(message)

    over(end, "send", send)
    examined(end)
    # Its servo follows within 10 ms: at 20 mm/s it is 0.3 mm behind, where a jump would be of 1 mm.
    assert 0.1 < max(ahead_mm) < 0.4


def test_no_finger_gets_more_force_than_announced() -> None:
    end = VirtualNode(Exoskeleton())
    examined(end)
    forces = [values_of(message, "FingerForces") for message in end.said if len(message.data) == 8]
    assert max(values[finger] for values in forces for finger in FINGERS) == pytest.approx(0.3)


def test_another_device_is_left_alone() -> None:
    end = VirtualModule(TactTip(1, BORN_S))
    results = examined(end, expected_finger=3)
    stopped(results, "the index tacttip: not the expected device, so it is not tried")
    assert commands(end) == []


def test_a_device_that_disappears_while_driven_fails() -> None:
    end = VirtualModule(TactTip(1, BORN_S))

    def send(below: Callable[[bytes], None], data: bytes) -> None:
        below(data)
        if end.module.drive:  # type: ignore[attr-defined]
            raise DeviceAbsent("a virtual line: brown-out")

    over(end, "send", send)
    results = examined(end)
    stopped(results, "brown-out")
    assert commands(end)[-1] == TactTipCommand(0, 0)


def test_an_unjudged_device_is_made_neutral_too() -> None:
    end = VirtualModule(ThermalSensor(1, BORN_S))
    drives = Drives(ModuleTalk(end))

    def check(device: Drives) -> Outcome:
        device.drive(100)
        raise NotApplicable("no")

    def spy(_: object) -> Outcome:
        return Outcome(commands(end)[-1] == HeaterCommand(0), "")

    trials = [(Duty("D0", "", How.EXERCISE, check), drives), (Duty("D1", "", How.LISTEN, spy), None)]
    results = OnTrial("a module", trials, drives, {}).tried(ALL, lambda _: None)
    assert [tried.verdict for tried in results] == [Verdict.NOT_APPLICABLE, Verdict.PASS]


def test_a_host_that_paused_does_not_blame_the_device() -> None:
    end = VirtualNode(Exoskeleton())
    waiting: list[can.Message] = []

    def send(below: Callable[[can.Message], None], message: can.Message) -> None:
        below(message)
        if len(end.said) == 25:
            waiting.extend(end.receive(0.2))

    def receive(below: Callable[[float], Iterator[can.Message]], seconds: float) -> Iterator[can.Message]:
        while waiting:
            yield waiting.pop(0)
        yield from below(seconds)

    over(end, "receive", receive)
    over(end, "send", send)
    results = examined(end)
    obeys = next(tried for tried in results if tried.duty.number == "N7")
    assert obeys.verdict is Verdict.NOT_APPLICABLE
    assert obeys.came == "this host paused for 210 ms during the trial: try again"


def test_the_other_node_is_left_alone() -> None:
    end = VirtualNode(Exoskeleton())
    with pytest.raises(ValueError, match="the exoskeleton is there; expected the telemanipulator"):
        NodeTalk(end, KINDS[NodeName.TELEMANIPULATOR])
    assert end.said == []


def test_a_bus_that_a_site_commands_is_left_alone() -> None:
    end = VirtualNode(Exoskeleton())
    other = can.Message(arbitration_id=0x110, data=bytes(8), is_extended_id=False)
    end.spoil = lambda frame: [frame, other]
    with pytest.raises(ValueError, match="FingerForces is on the bus: end the site"):
        NodeTalk(end, KINDS[NodeName.EXOSKELETON])
    assert end.said == []


def test_a_bus_without_a_node_is_reported() -> None:
    end = BusEnd(CanAddress(interface="virtual", channel="nobody"))
    with pytest.raises(DeviceAbsent, match="CAN virtual:nobody: open, but no state frame of a node heard"):
        name_of(end)
    end.close()
