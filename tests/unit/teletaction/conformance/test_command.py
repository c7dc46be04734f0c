"""The command line of `conformance`: what it prints, its exit codes, and that it asks before it drives anything."""

import io
import json
from collections.abc import Callable
from typing import Any

import pytest

from common.buses.can_address import can_address
from sim_sensors.devices.exoskeleton import Exoskeleton
from sim_sensors.devices.tacttip import TactTip
from sim_sensors.devices.telemanipulator import Telemanipulator
from teletaction.conformance import examination
from tests.commands import command, one_line
from tests.unit.teletaction.conformance.virtual_ends import VirtualModule, VirtualNode
from tests.unit.teletaction.conformance.wrong_drives import strange_flag

ADDRESS = "/dev/serial/by-id/virtual"
BUS = "socketcand://127.0.0.1:1/can0"


@pytest.fixture
def at(monkeypatch: pytest.MonkeyPatch) -> Callable[[Any], Any]:
    """Puts a virtual device where the command opens its address."""

    def put(end: Any) -> Any:
        end.close = lambda: None
        monkeypatch.setattr(examination, "BusEnd" if isinstance(end, VirtualNode) else "PortEnd", lambda address: end)
        return end

    return put


def test_a_sound_module_passes(at: Callable[[Any], Any]) -> None:
    at(VirtualModule(TactTip(1, 90.0)))
    result = command("conformance", ADDRESS, "--device", "tacttip", "--finger", "index", "--heat", "--yes")
    assert result.code == 0, result
    lines = result.out.splitlines()
    assert lines[0].split(maxsplit=3) == ["S1", "pass", "expected:", lines[0].split(maxsplit=3)[3]]
    assert lines[1].strip().startswith("came:")
    assert result.err == f"tacttip TT0001 at {ADDRESS}: 38 pass\n"


def test_a_wrong_module_fails_and_its_first_duty_is_named(at: Callable[[Any], Any]) -> None:
    at(strange_flag())
    result = command("conformance", ADDRESS)
    assert result.code == 1
    assert "D2   FAIL      expected: Flags that the page does not name are 0\n" in result.out
    assert result.err.splitlines()[-1] == "teletaction: D2: Flags that the page does not name are 0: 0x81"


def test_results_are_written_as_json(at: Callable[[Any], Any]) -> None:
    at(strange_flag())
    result = command("conformance", ADDRESS, "--json")
    found = json.loads(result.out)
    assert (result.code, found["address"]) == (1, ADDRESS)
    assert (found["counts"]["FAIL"], found["counts"]["not tried"]) == (1, 13)
    duties = {row["duty"]: row for row in found["duties"]}
    assert duties["D2"] == {
        "duty": "D2",
        "verdict": "FAIL",
        "expected": "Flags that the page does not name are 0",
        "came": "0x81",
    }
    assert (duties["D4"]["verdict"], duties["D4"]["came"]) == ("not tried", "needs --exercise")


@pytest.mark.parametrize(("node", "frames"), [(Exoskeleton, 2), (Telemanipulator, 2)])
def test_a_node_is_identified_by_its_frames(at: Callable[[Any], Any], node: Callable[[], Any], frames: int) -> None:
    end = at(VirtualNode(node()))
    result = command("conformance", BUS, "--exercise", "--yes")
    assert result.code == 0, result
    assert result.err.startswith(f"{node.__name__.lower()} at {BUS}: ")
    assert len(end.said) > frames


@pytest.mark.parametrize(("answer", "code"), [("n\n", 130), ("", 130), ("y\n", 0)])
def test_nothing_is_driven_without_confirmation(
    at: Callable[[Any], Any], monkeypatch: pytest.MonkeyPatch, answer: str, code: int
) -> None:
    end = at(VirtualNode(Exoskeleton()))
    monkeypatch.setattr("sys.stdin", io.StringIO(answer))
    result = command("conformance", BUS, "--exercise")
    assert (result.code, bool(result.out.strip()), bool(end.said)) == (code, code == 0, code == 0)
    assert "pushes with 0.3 N on each finger" in result.err


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("/dev/none",), "/dev/none"),
        (("socket://127.0.0.1:1",), "socket://127.0.0.1:1"),
        (("socketcand://nowhere",), "a CAN bus is socketcan:CHANNEL or socketcand://HOST:PORT/CHANNEL"),
        (("socket://127.0.0.1",), "a device behind TCP is socket://HOST:PORT"),
        (("socketcan:can77",), "can77 is no CAN interface of this host: deploy/network/README.md"),
        (
            ("socketcand://[::1]:29536/can0",),
            "socketcand://[::1]:29536/can0: host: a CAN gateway needs a name or an IPv4",
        ),
        (("socketcand://gateway:99999/can0",), "socketcand://gateway:99999/can0: port: Input should be less than"),
        (("socketcan:can0", "--device", "tacttip"), "a tacttip is a serial device, not on CAN"),
        (("/dev/none", "--device", "exoskeleton"), "the exoskeleton is on CAN"),
        (("socketcan:can0", "--finger", "index"), "a CAN node serves all fingers"),
        (("/dev/none", "--finger", "toe"), "--finger toe: there are thumb, index"),
    ],
)
def test_bad_input_is_one_line(arguments: tuple[str, ...], says: str) -> None:
    assert says in one_line(command("conformance", *arguments), 2)


@pytest.mark.parametrize(
    ("text", "read"),
    [(text, text) for text in ("socketcan:can0", "socketcand://10.0.0.7:29536/can1", "virtual:a bus")]
    + [(text, text) for text in ("socketcan:vcan-1.2", "socketcand://sim-remote:29536/vcan-1.2")]
    + [(text, "") for text in ("/dev/ttyUSB0", "socket://127.0.0.1:7001")],
)
def test_a_can_address_is_read_as_written_and_a_serial_one_is_no_can_address(text: str, read: str) -> None:
    assert str(can_address(text) or "") == read
