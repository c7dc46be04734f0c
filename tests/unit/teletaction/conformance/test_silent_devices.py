"""A device whose reports stop, or come all at once, ends no examination and passes no duty by its silence."""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import can
import pytest

from common.buses.can_frames import packing
from common.buses.serial_messages import MessageId
from sim_sensors.devices.exoskeleton import Exoskeleton
from sim_sensors.devices.tacttip import TactTip
from sim_sensors.devices.telemanipulator import Telemanipulator
from sim_sensors.devices.texture_sensor import TextureSensor
from sim_sensors.devices.thermal_sensor import ThermalSensor
from teletaction.conformance.checklist import How, Unsafe, Verdict
from teletaction.conformance.cut_out import Heating
from teletaction.conformance.drives import Drives
from teletaction.conformance.exoskeleton_node import EXOSKELETON
from teletaction.conformance.module_talk import ModuleTalk
from tests.unit.teletaction.conformance.examining import came, examined
from tests.unit.teletaction.conformance.spoiled_module import BORN_S, over
from tests.unit.teletaction.conformance.virtual_ends import VirtualModule, VirtualNode

LISTENING = frozenset({How.LISTEN})


def saying(end: VirtualModule, chosen: Callable[[int], int]) -> VirtualModule:
    """Send each report, by its number, as many times as chosen."""
    count = 0

    def say(below: Callable[..., None], message_id: MessageId, payload: bytes) -> None:
        nonlocal count
        count += message_id != MessageId.IDENTITY
        for _ in range(1 if message_id == MessageId.IDENTITY else chosen(count)):
            below(message_id, payload)

    over(end.module, "_say", say)
    return end


def test_two_reports_at_once_have_no_rate() -> None:
    end = saying(VirtualModule(ThermalSensor(1, BORN_S)), lambda count: 2 * (count == 300))
    assert {"S9", "S10"} <= came(examined(end, LISTENING), Verdict.NOT_APPLICABLE).keys()


def test_two_frames_at_once_have_no_rate() -> None:
    end, paired = VirtualNode(Exoskeleton()), set[int]()

    def spoil(frame: can.Message) -> list[can.Message]:
        since_s = end.now() - 100.0
        if since_s < 0.2:
            return [frame]
        if since_s < 0.3 or frame.arbitration_id in paired:
            return []
        paired.add(frame.arbitration_id)
        return [frame, frame]

    end.spoil = spoil
    assert "N5" in came(examined(end, LISTENING), Verdict.NOT_APPLICABLE)


def test_a_module_that_falls_silent_before_it_is_heated_stops_everything() -> None:
    end, silent = VirtualModule(ThermalSensor(1, BORN_S)), False
    drives = Drives(ModuleTalk(saying(end, lambda _: int(not silent))))

    def ready(below: Callable[[], object]) -> object:
        nonlocal silent
        found = below()
        silent = True
        return found

    over(drives, "ready", ready)
    with pytest.raises(Unsafe, match="no reports while it is heated"):
        _ = Heating(drives).found


@pytest.mark.parametrize(
    ("kind", "reports", "number"),
    [(ThermalSensor, 350, "S9"), (TextureSensor, 1200, "S16"), (ThermalSensor, 600, "S16")],
)
def test_a_module_whose_reports_end_while_it_is_listened_to_fails(
    kind: Callable[..., Any], reports: int, number: str
) -> None:
    end = saying(VirtualModule(kind(1, BORN_S)), lambda count: int(count <= reports))
    assert number in came(examined(end, LISTENING), Verdict.FAIL)


@pytest.mark.parametrize(
    ("kind", "reports"), [(ThermalSensor, 1100), (ThermalSensor, 1200), (ThermalSensor, 1500), (TactTip, 2200)]
)
def test_a_module_whose_reports_end_is_driven_no_further(kind: Callable[..., Any], reports: int) -> None:
    results = examined(saying(VirtualModule(kind(1, BORN_S)), lambda count: int(count <= reports)))
    failed = next(n for n, tried in enumerate(results) if tried.verdict is Verdict.FAIL)
    assert results[failed].came == "no more reports"
    assert {tried.verdict for tried in results[failed + 1 :]} == {Verdict.NOT_TRIED}


@pytest.mark.parametrize(("kind", "after_s", "number"), [(Exoskeleton, 1.2, "N5"), (Telemanipulator, 3.2, "N7")])
def test_a_node_whose_frames_end_fails_and_is_driven_no_further(
    kind: Callable[[], Any], after_s: float, number: str
) -> None:
    end = VirtualNode(kind())
    end.spoil = lambda frame: [frame] if end.now() - 100.0 < after_s else []
    results = examined(end)
    assert next(iter(came(results, Verdict.FAIL))) == number
    assert not {"N8", "N9", "N11", "E3", "M4"} & came(results, Verdict.PASS).keys()


@pytest.mark.parametrize(("kind", "numbers"), [(Exoskeleton, {"N8", "E3"}), (Telemanipulator, {"N8"})])
def test_a_node_without_state_frames_passes_no_time_out(kind: Callable[[], Any], numbers: set[str]) -> None:
    end, state = VirtualNode(kind()), packing(f"{kind.__name__}State").frame_id  # type: ignore[attr-defined]
    end.spoil = lambda frame: [] if frame.arbitration_id == state else [frame]
    assert numbers <= came(examined(end), Verdict.NOT_APPLICABLE).keys()


def test_repeated_numbers_are_not_called_missing() -> None:
    results = examined(saying(VirtualModule(ThermalSensor(1, BORN_S)), lambda _: 1), LISTENING)
    assert "0 numbers missing and 0 repeated" in came(results, Verdict.PASS)["S6"]


def test_an_exoskeleton_that_falls_silent_after_a_change_is_said_to_have_reported_nothing() -> None:
    (duty,) = (duty for duty in EXOSKELETON.duties if duty.number == "E5")
    talk = SimpleNamespace(repeat=lambda *_: [], states=lambda _: [(1.0, {"enabled": 0.0})])
    tried = duty.tried_on(SimpleNamespace(talk=talk, acting=lambda _: {}))
    assert (tried.verdict, tried.came) == (Verdict.NOT_APPLICABLE, "no state frame after a change")
