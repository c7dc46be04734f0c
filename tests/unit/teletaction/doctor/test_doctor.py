"""The doctor without a session: findings on a host, and devices that are elsewhere."""

import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import pytest

from common.buses.can_address import CanAddress
from common.buses.serial_port import DeviceAbsent
from sim_sensors.devices.breakable_parts import Babble
from sim_sensors.devices.exoskeleton import Exoskeleton
from sim_sensors.devices.tacttip import TactTip
from sim_sensors.ports.select_loop import SelectLoop
from sim_sensors.ports.serial_server import SerialServer, serve_serial
from teletaction.conformance.examination import CHECKLISTS
from teletaction.conformance.find_devices import can_interfaces, find_modules, require_interface
from teletaction.doctor import doctor
from teletaction.doctor.doctor import EXERCISES, examine
from tests.commands import command, one_line
from tests.unit.teletaction.conformance.living import alive, exoskeleton

pytestmark = pytest.mark.long

INDEX = 1


@pytest.fixture
def ports(tmp_path: Path) -> Iterator[Path]:
    """A folder of serial ports: the index finger's TactTip, and one that says nothing."""
    with served(tmp_path) as folder:
        yield folder


@contextmanager
def served(tmp_path: Path, babble: Babble | None = None) -> Iterator[Path]:
    """Serve both ports; `babble` is noise on the line of the TactTip."""
    folder = tmp_path / "by-id"
    folder.mkdir()
    loop = SelectLoop()
    servers: list[SerialServer] = [
        serve_serial(TactTip(INDEX, loop.now()), loop, "pty", name) for name in ("good", "mute")
    ]
    servers[0].babble = babble
    servers[1].silent = True
    for server, name in zip(servers, ("usb-good", "usb-mute"), strict=True):
        (folder / name).symlink_to(server.address)

    def step(now_s: float) -> None:
        for server in servers:
            server.pump(now_s)

    with alive(loop, step):
        yield folder
    for server in servers:
        server.close()


@pytest.fixture
def config(configs: dict[str, Path]) -> Path:
    """An operator site of one finger whose TactTip is nowhere."""
    text = configs["operator"].read_text("utf-8")
    configs["operator"].write_text(re.sub(r'(?m)^index = ".*"$', 'index = "/dev/nowhere"', text), "utf-8")
    return configs["operator"]


def test_devices_that_answer_are_named_without_a_configuration(ports: Path, tmp_path: Path) -> None:
    good, mute = find_modules(ports)
    assert (good.address, good.words) == (str(ports / "usb-good"), "index tacttip, serial number TT0001, firmware 1")
    assert (mute.good, mute.words) == (False, "a port, but no device answers IDENTIFY within 1 s")
    result = command("doctor", "--ports", ports)
    assert result.code == 0
    assert f"{good.address}: index tacttip, serial number TT0001" in result.out
    line = one_line(command("doctor", "--ports", tmp_path / "nothing"), 1)
    assert "no device answers" in line
    assert line.endswith(f"; there is no folder {tmp_path / 'nothing'}")


def test_unknown_devices_are_not_driven_and_exercises_are_duties_of_the_page() -> None:
    assert "--exercise needs --config" in one_line(command("doctor", "--exercise", "--yes"), 2)
    assert {duty.number for checklist in CHECKLISTS for duty in checklist.duties} >= EXERCISES


@pytest.mark.usefixtures("usual_speed")
def test_missing_devices_are_reported(configs: dict[str, Path]) -> None:
    result = command("doctor", "--config", configs["remote"])
    assert result.code == 1
    lines = result.out.splitlines()
    assert lines[0].startswith("ok   own key: curve:")
    assert [line.split(":")[0] for line in lines if line.startswith("FAIL")] == [
        "FAIL index texture sensor",
        "FAIL index thermal sensor",
        "FAIL patient switch",
        "FAIL telemanipulator",
    ]
    assert "Connection refused" in result.out
    (priority,) = (line for line in lines if "loop's priority" in line)
    assert priority.startswith(("ok   loop's priority: real-time", "ok   loop's priority: ordinary"))


@pytest.mark.parametrize(("free_gb", "good"), [(0.0, False), (0.9, False), (1.1, True)])
def test_a_disk_without_room_for_an_hour_of_recording_is_found(
    free_gb: float, good: bool, configs: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shutil, "disk_usage", lambda path: SimpleNamespace(free=free_gb * 1e9))
    kept = re.sub(r"(?m)^(record|status) = .*\n", "", configs["operator"].read_text("utf-8"))
    lines = [f'{name} = "{tmp_path / name}"' for name in ("record", "status")]
    configs["operator"].write_text("\n".join([*lines, kept]), "utf-8")
    found = {finding.what: finding for finding in examine(configs["operator"])}
    assert found["recording"].good is good
    assert ("make room" in found["recording"].result) is not good
    assert found["status file"].good, "a status file has one size"


@pytest.mark.parametrize("name", ["record", "status"])
@pytest.mark.parametrize(
    ("made", "words"),
    [
        ("new.mcap", None),
        ("no-folder/new.mcap", "cannot be written: No such file or directory"),
        ("file/new.mcap", "cannot be written: Not a directory"),
        ("link", "cannot be written: is a symbolic link, refused"),
        ("folder", "is a folder; name a file in it"),
    ],
)
def test_a_file_that_a_site_cannot_write_is_found(
    name: str, made: str, words: str | None, configs: dict[str, Path], tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("")
    (tmp_path / "folder").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "file")
    kept = re.sub(r"(?m)^(record|status) = .*\n", "", configs["operator"].read_text("utf-8"))
    configs["operator"].write_text(f'{name} = "{tmp_path / made}"\n{kept}', "utf-8")
    checked = {"record": "recording", "status": "status file"}[name]
    (found,) = (finding for finding in examine(configs["operator"]) if finding.what in ("recording", "status file"))
    assert (found.what, found.good) == (checked, words is None)
    assert found.result.startswith(f"{tmp_path / made}: ")
    assert (words or " GB free") in found.result
    assert not list((tmp_path / "folder").iterdir())


@pytest.mark.parametrize(
    ("step_s", "good", "words"),
    [
        (50e-6, True, "250 ticks a second take 0.12 of a processor of this machine; rate_hz = 1000 fits, too (0.28)"),
        (200e-6, True, "250 ticks a second take 0.49 of a processor of this machine"),
        (400e-6, False, "at most 0.7 fit: lower rate_hz, or a faster machine"),
    ],
)
def test_the_rate_is_compared_with_the_machine(
    step_s: float, good: bool, words: str, configs: dict[str, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(doctor, "reference_step_s", lambda: step_s)
    (rate,) = (finding for finding in examine(configs["remote"]) if finding.what == "loop's rate")
    assert rate.good == good
    assert words in rate.result


def test_a_device_elsewhere_is_found(config: Path, ports: Path) -> None:
    findings = [finding for finding in examine(config, ports=ports) if finding.what == "index tacttip"]
    assert [finding.good for finding in findings] == [False, False]
    assert "/dev/nowhere" in findings[0].result
    assert findings[1].result == f'found elsewhere: write index = "{ports / "usb-good"}"'


def test_a_device_of_another_finger_is_named(config: Path, ports: Path) -> None:
    text = config.read_text("utf-8").replace('index = "/dev/nowhere"', f'ring = "{ports / "usb-good"}"')
    config.write_text(text.replace('fingers = ["index"]', 'fingers = ["ring"]'), "utf-8")
    (finding,) = [each for each in examine(config, ports=ports) if each.what == "ring tacttip" and not each.good][:1]
    assert "is the index tacttip, serial number TT0001, firmware 1; expected the ring tacttip" in finding.result


def test_noise_on_a_line_is_reported_where_the_device_is(config: Path, tmp_path: Path) -> None:
    with served(tmp_path, Babble(921_600)) as ports:
        text = config.read_text("utf-8").replace("/dev/nowhere", str((ports / "usb-good").resolve()))
        config.write_text(text, "utf-8")
        (finding,) = [each for each in examine(config, ports=ports) if each.what == "index tacttip"]
    assert not finding.good
    assert re.search(r": \d+ messages and [1-9]\d* damaged a second, the device promises 100$", finding.result)


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (None, r"^CAN {bus}: HandPose \d+/s, FingerHeights \d+/s, ExoskeletonState \d+/s$"),
        (("crc", 0.5), r"^CAN {bus}: \w+: \d+ of the last \d+ frames damaged, at most 10$"),
    ],
)
def test_frames_of_a_node_are_counted(damage: tuple[str, float] | None, words: str, config: Path) -> None:
    node = Exoskeleton()
    with exoskeleton(node) as server:
        node.transmitter.damage = damage
        bus = f"socketcand://127.0.0.1:{server.port}/can0"
        text = re.sub(r"(?m)^port = .*$", f"port = {server.port}", config.read_text("utf-8"))
        config.write_text(text, "utf-8")
        (finding,) = [each for each in examine(config) if each.what == "exoskeleton"]
    assert finding.good == (damage is None)
    assert re.search(words.format(bus=re.escape(bus)), finding.result)


def test_an_absent_gateway_is_named_once(config: Path) -> None:
    (finding,) = [each for each in examine(config) if each.what == "exoskeleton"]
    assert re.fullmatch(r"CAN socketcand://[^ ]+: \[Errno 111\] Connection refused", finding.result)


def test_the_congestion_control_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, config: Path) -> None:
    kernel = tmp_path / "tcp_congestion_control"
    monkeypatch.setattr(doctor, "CONGESTION_CONTROL", kernel)
    results = []
    for control in ("bbr\n", "cubic\n", None):
        kernel.write_text(control) if control else kernel.unlink()
        (finding,) = [each for each in examine(config) if each.what == "TCP congestion control"]
        assert finding.good
        results.append(finding.result)
    assert results[0] == "bbr"
    assert results[1].startswith("cubic: where packets are lost, the link gets too slow")
    assert results[2] == "unknown: No such file or directory"


def test_can_interfaces_come_from_the_kernels_list(tmp_path: Path) -> None:
    for name, kind, state in (("can0", "280", "up"), ("can1", "280", "down"), ("eth0", "1", "up")):
        (tmp_path / name).mkdir()
        (tmp_path / name / "type").write_text(f"{kind}\n")
        (tmp_path / name / "operstate").write_text(f"{state}\n")
    assert can_interfaces(tmp_path) == {"can0": True, "can1": False}
    assert can_interfaces(tmp_path / "nothing") == {}
    require_interface(CanAddress(interface="socketcan", channel="can0"), tmp_path)
    with pytest.raises(DeviceAbsent, match="can1 is down"):
        require_interface(CanAddress(interface="socketcan", channel="can1"), tmp_path)


def test_inherited_real_time_priority_is_reported(configs: dict[str, Path]) -> None:
    chrt = shutil.which("chrt")
    if chrt is None or subprocess.run((chrt, "--rr", "1", "true"), capture_output=True, check=False).returncode:
        pytest.skip("no real-time policy may be set here")
    doctor = (chrt, "--rr", "1", sys.executable, "-m", "teletaction", "doctor", "--config", configs["remote"])
    result = subprocess.run(doctor, capture_output=True, text=True, check=False)
    assert "loop's priority: real-time, inherited from the parent process" in result.stdout
