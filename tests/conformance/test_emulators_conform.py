"""The emulators keep every duty of docs/protocols.md."""

import pytest

from sim_sensors.exoskeleton import Exoskeleton
from sim_sensors.serial_module import SerialModule
from sim_sensors.tacttip import TactTip
from sim_sensors.telemanipulator import Telemanipulator
from sim_sensors.texture_sensor import TextureSensor
from sim_sensors.thermal_sensor import ThermalSensor
from teletaction.conformance.checklist import How, Tried, Verdict
from teletaction.conformance.examination import module_on_trial, node_on_trial
from teletaction.conformance.module_talk import ModuleTalk
from teletaction.conformance.node_talk import KINDS, NodeName, NodeTalk
from tests.conformance.virtual_ends import VirtualModule, VirtualNode

NOT_TOLD = {"S3"}


def verdicts(results: list[Tried]) -> dict[str, tuple[Verdict, str]]:
    return {tried.duty.number: (tried.verdict, tried.came) for tried in results}


def examine_module(end: VirtualModule) -> dict[str, tuple[Verdict, str]]:
    return verdicts(module_on_trial(ModuleTalk(end)).tried(frozenset(How), lambda _: None))


def examine_node(end: VirtualNode, name: NodeName) -> dict[str, tuple[Verdict, str]]:
    return verdicts(node_on_trial(NodeTalk(end, KINDS[name])).tried(frozenset(How), lambda _: None))


@pytest.mark.parametrize("module", [TextureSensor(1, 90.0), ThermalSensor(2, 90.0), TactTip(3, 90.0)])
def test_every_emulated_module_keeps_every_duty(module: SerialModule) -> None:
    found = examine_module(VirtualModule(module))
    others = {number: came for number, came in found.items() if came[0] is not Verdict.PASS and number not in NOT_TOLD}
    assert others == {}


def test_the_emulated_exoskeleton_keeps_every_duty() -> None:
    found = examine_node(VirtualNode(Exoskeleton()), NodeName.EXOSKELETON)
    assert {number: came for number, came in found.items() if came[0] is not Verdict.PASS} == {}


def test_the_emulated_telemanipulator_keeps_every_duty() -> None:
    found = examine_node(VirtualNode(Telemanipulator()), NodeName.TELEMANIPULATOR)
    assert {number: came for number, came in found.items() if came[0] is not Verdict.PASS} == {}
