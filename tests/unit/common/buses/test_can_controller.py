"""Reports of a CAN controller have names, and its state follows."""

import pytest

from common.buses.can_controller import BUS_OFF, CONTROLLER, NO_ACKNOWLEDGE, RESTARTED, CanController


def detail(bits: int) -> bytes:
    return bytes((0, bits, 0, 0, 0, 0, 0, 0))


@pytest.mark.parametrize(
    ("error", "data", "names", "state"),
    [
        (CONTROLLER, detail(0x08), ["warning"], "warning"),
        (CONTROLLER, detail(0x04), ["warning"], "warning"),
        (CONTROLLER, detail(0x10), ["error-passive"], "error-passive"),
        (CONTROLLER, detail(0x28), ["error-passive"], "error-passive"),
        (CONTROLLER, detail(0x01), ["receive overflow"], "error-active"),
        (CONTROLLER, detail(0x02), ["transmit overflow"], "error-active"),
        (CONTROLLER, b"\0", ["controller problem"], "error-active"),
        (NO_ACKNOWLEDGE, b"\0", ["no acknowledge"], "error-active"),
        (BUS_OFF | CONTROLLER, b"\0", ["controller problem", "bus off"], "bus off"),
        (0x400, b"", ["other error"], "error-active"),
    ],
)
def test_each_error_has_a_name_and_a_count(error: int, data: bytes, names: list[str], state: str) -> None:
    controller = CanController()
    assert controller.report(error, data) == names
    assert controller.state == state
    assert controller.counts == dict.fromkeys(names, 1)
    assert controller.off == (state == "bus off")


def test_a_controller_recovers_by_its_own_report_and_leaves_bus_off_by_a_restart_or_a_frame() -> None:
    controller = CanController()
    controller.report(CONTROLLER, detail(0x20))
    controller.alive()
    assert controller.state == "error-passive", "frames that come do not hide it"
    controller.report(CONTROLLER, detail(0x08))
    assert controller.state == "warning"
    controller.report(CONTROLLER, detail(0x40))
    assert controller.state == "error-active"
    controller.report(BUS_OFF, b"\0")
    controller.report(CONTROLLER, detail(0x40))
    assert controller.off
    controller.alive()
    assert controller.state == "error-active"
    controller.report(BUS_OFF, b"\0")
    controller.report(RESTARTED, b"\0")
    assert controller.state == "error-active"
    assert controller.counts["error-active"] == 2


def test_any_report_of_a_gateway_has_one_of_few_names() -> None:
    controller = CanController()
    for error in range(0, 1 << 16, 7):
        controller.report(error << 4 | error & 0xF, bytes((0, error & 0xFF)))
    assert len(controller.counts) < 20
