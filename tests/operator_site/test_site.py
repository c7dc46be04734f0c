"""The operator site's tick with devices and link in the test's hands."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

from common.can_line import CanAddress
from common.config import OperatorConfig, OperatorLinkConfig
from common.fingers import FINGERS
from common.link import OperatorLink
from common.packets import LinkState
from operator_site.devices import OperatorDevices
from operator_site.exoskeleton import Hand
from operator_site.gate import GatedOutput
from operator_site.site import OperatorSite

MS = 1_000_000


class SilentLink:
    """Nobody on the other side."""

    def receive(self, stream: str) -> list[bytes]:
        return []

    def receive_latest(self, stream: str) -> None:
        return None

    def send(self, stream: str, packet: bytes) -> bool:
        return False

    def send_latest(self, stream: str, packet: bytes) -> None:
        raise AssertionError("no motion without a session")


@dataclass
class Devices:
    """Devices that do what the test says, and remember what reached them."""

    hand: Hand = field(default_factory=Hand)
    cut: list[int] = field(default_factory=list)
    written: list[tuple[GatedOutput, bool]] = field(default_factory=list)

    def read(self, t_s: float) -> Hand:
        self.hand.pose_s = self.hand.heights_s = t_s
        return self.hand

    def missing(self) -> str:
        return ""

    def cut_out(self) -> list[int]:
        return self.cut

    def plates(self, t_s: float) -> tuple[list[float], list[float]]:
        return [33.0] * len(FINGERS), [0.0] * len(FINGERS)

    def write(self, t_s: float, output: GatedOutput, engaged: bool) -> None:
        self.written.append((output, engaged))

    def figures(self) -> dict[str, object]:
        return {}


def site(devices: Devices) -> OperatorSite:
    config = OperatorConfig(
        fingers=("index",),
        link=OperatorLinkConfig(keys=Path("keys")),
        tacttip={"index": "pty"},
        exoskeleton=CanAddress(interface="virtual"),
        engage=True,
    )
    return OperatorSite(config, cast(OperatorLink, SilentLink()), cast(OperatorDevices, devices), None)


def run(operator: OperatorSite, first: int, ticks: int) -> int:
    for tick in range(first, first + ticks):
        operator.tick(1_000 * MS + tick * 2 * MS)
    return first + ticks


def test_without_a_far_side_everything_is_neutral() -> None:
    devices = Devices()
    run(site(devices), 0, 200)
    assert len(devices.written) == 200
    for output, engaged in devices.written:
        assert not engaged
        assert output.force_n == output.motor_rpm == output.peltier_drive == [0.0] * len(FINGERS)


def test_a_module_that_cut_out_latches_a_fault_until_it_is_cleared() -> None:
    devices = Devices()
    operator = site(devices)
    session = operator.client.session
    now = run(operator, 0, 5)
    assert session.state is LinkState.DISCONNECTED
    devices.cut = [FINGERS.index("index")]
    now = run(operator, now, 2)
    assert session.state is LinkState.FAULT
    assert session.fault.startswith("index: ")
    session.clear()
    now = run(operator, now, 2)
    assert session.state is LinkState.FAULT, "the module still says so"
    devices.cut = []
    now = run(operator, now, 2)
    assert session.state is LinkState.FAULT, "a fault latches"
    session.clear()
    run(operator, now, 2)
    assert session.state is LinkState.DISCONNECTED
    assert operator.gate.fault is None
    figures: dict[str, Any] = operator.figures()
    assert figures["fault"] == ""
    assert figures["limited"]["index"] == ("released",)
