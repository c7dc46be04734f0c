"""The ends that are used on hardware, on a real pseudo terminal and on real sockets."""

import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from common.buses.can_address import CanAddress
from common.buses.can_frames import FrameReceiver
from common.buses.serial_device import open_line
from common.buses.serial_messages import DeviceKind, encode_frame
from common.buses.serial_port import DeviceAbsent
from common.fingers import FINGERS
from sim_sensors.devices.exoskeleton import Exoskeleton
from sim_sensors.devices.thermal_sensor import ThermalSensor
from teletaction.conformance.module_talk import ModuleTalk, PortEnd
from teletaction.conformance.node_talk import EXOSKELETON, BusEnd, NodeName, NodeTalk, name_of
from teletaction.session.demo_files import DemoOptions, prepare
from tests.unit.teletaction.conformance.living import exoskeleton, thermal_sensor
from tests.unit.teletaction.conformance.spoiled_module import over
from tests.unit.teletaction.conformance.virtual_ends import VirtualModule

pytestmark = pytest.mark.long


@pytest.mark.parametrize("where", ["pty", "tcp:127.0.0.1:0"])
def test_a_module_is_talked_to(where: str) -> None:
    with thermal_sensor(where) as server, closing(PortEnd(server.address)) as end:
        talk = ModuleTalk(end)
        assert talk.kind is DeviceKind.THERMAL_SENSOR
        assert talk.identity is not None
        assert talk.identity.serial == "TH0001"
        assert len(talk.ask(1.0)) == 1
        end.look_away(0.05)
        assert talk.reports(talk.listen(0.2))


def test_a_port_is_not_shared() -> None:
    with thermal_sensor() as server:
        site = open_line(server.address)
        with pytest.raises(DeviceAbsent, match=r"thermal.*another program has it"):
            PortEnd(server.address)
        site.port.close()
        PortEnd(server.address).close()


def test_a_silent_module_is_absent_unless_its_kind_is_given() -> None:
    with thermal_sensor(silent=True) as server, closing(PortEnd(server.address)) as end:
        with pytest.raises(DeviceAbsent, match=r"thermal: no answer.*0 other frames, 0 damaged .is it powered"):
            ModuleTalk(end)
        assert ModuleTalk(end, DeviceKind.TACTTIP).kind is DeviceKind.TACTTIP


@pytest.mark.parametrize(
    ("says", "problem"),
    [
        (b"\xf0\x0f\xaa\x55\0", "no answer to IDENTIFY within 1 s, 0 other frames, .*is it at 921600 baud"),
        (
            encode_frame(0x20, 1, bytes(11)),
            "no answer to IDENTIFY within 1 s, [1-9][0-9]* other frames, 0 damaged; --dev",
        ),
        (encode_frame(0x02, 1, bytes(22)), "identity: .*; --device KIND tries"),
    ],
)
def test_the_reason_why_a_device_is_not_identified_is_named(says: bytes, problem: str) -> None:
    end = VirtualModule(ThermalSensor(1))
    end.module.take_output = lambda now_s: says  # type: ignore[method-assign]
    with pytest.raises(DeviceAbsent, match=f"a virtual line: {problem}"):
        ModuleTalk(end)


def test_a_lost_line_is_reported() -> None:
    with thermal_sensor("tcp:127.0.0.1:0") as server:
        end = PortEnd(server.address)
    with closing(end), pytest.raises(DeviceAbsent, match="socket://"):
        list(end.receive(1.0))


def test_a_node_is_talked_to() -> None:
    with exoskeleton(Exoskeleton()) as bus:
        end = BusEnd(CanAddress(interface="socketcand", port=bus.port))
        assert name_of(end) is NodeName.EXOSKELETON
        talk = NodeTalk(end, EXOSKELETON)
        talk.say("FingerForces", {"enabled": 1.0, **dict.fromkeys(FINGERS, 0.2)})
        states = talk.states(talk.listen(0.1))
        assert states[-1][1]["enabled"] == 1.0
        assert states[-1][0] > states[0][0]
        end.close()


def test_frames_from_before_the_user_agreed_are_not_judged() -> None:
    with exoskeleton(Exoskeleton()) as bus:
        end = BusEnd(CanAddress(interface="socketcand", port=bus.port))
        talk = NodeTalk(end, EXOSKELETON)
        asked_s = talk.listen(0.1)[-1].timestamp
        time.sleep(0.5)
        assert talk.at_rest[0].timestamp > asked_s + 0.4
        time.sleep(0.5)
        command = {"enabled": 1.0, **dict.fromkeys(FINGERS, 0.2)}
        said = talk.repeat(lambda: talk.say("FingerForces", command), 0.3)
        assert said[0].timestamp > talk.at_rest[-1].timestamp + 0.4
        end.close()


@pytest.mark.parametrize(
    ("name", "number"),
    [("conformance", signal.SIGINT), ("conformance", signal.SIGTERM), ("doctor", signal.SIGHUP)],
)
def test_a_command_that_is_ended_leaves_the_device_neutral(name: str, number: int, tmp_path: Path) -> None:
    node = Exoskeleton()
    pushed, heard = threading.Event(), []

    def feed(below: Callable[..., None], frame_id: int, data: bytes, now_s: float) -> None:
        below(frame_id, data, now_s)
        heard.append(FrameReceiver("FingerForces").decode(data))
        if heard[-1]["enabled"]:
            pushed.set()

    over(node, "feed", feed)
    site = prepare(DemoOptions(fingers=1), tmp_path)["operator"]
    with exoskeleton(node) as bus:
        site.write_text(re.sub(r"(?m)^port = .*$", f"port = {bus.port}", site.read_text("utf-8")), "utf-8")
        what = {"conformance": [f"socketcand://127.0.0.1:{bus.port}/can0"], "doctor": ["--config", str(site)]}
        command = [sys.executable, "-m", "teletaction", name, *what[name], "--exercise", "--yes"]
        with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
            assert pushed.wait(30.0)
            process.send_signal(number)
            assert process.wait(10.0) == 130
    assert heard[-1] == {"enabled": 0.0, **dict.fromkeys(FINGERS, 0.0)}
