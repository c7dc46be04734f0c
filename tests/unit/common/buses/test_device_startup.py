import pytest

from common.buses.device_startup import DevicesMissing, wait_for_devices
from common.buses.serial_device import WrongDevice
from common.buses.serial_port import DeviceAbsent


class Rig:
    """Devices of which one comes at the n-th look."""

    def __init__(self, comes_at: int, problems: list[Exception]) -> None:
        self.looks = 0
        self._comes_at = comes_at
        self._problems = problems

    def read(self, t_s: float) -> object:
        self.looks += 1
        return None

    def missing(self) -> str:
        return "" if self.looks >= self._comes_at else "index tacttip: opening"

    def problems(self) -> list[Exception]:
        return self._problems


def test_a_timeout_names_the_missing_devices() -> None:
    with pytest.raises(DevicesMissing, match=r"index tacttip: opening \(waited 0 s\)"):
        wait_for_devices(Rig(10**9, [DeviceAbsent("no answer")]), 0.0)


def test_another_device_in_its_place_is_reported_at_once() -> None:
    rig = Rig(10**9, [DeviceAbsent("no answer"), WrongDevice("/dev/x: is the thumb's tacttip")])
    with pytest.raises(DevicesMissing, match="is the thumb's tacttip"):
        wait_for_devices(rig, 600.0)
    assert rig.looks == 1


@pytest.mark.parametrize("looks", [0, 1, 5])
def test_waiting_ends_when_all_devices_are_there_or_on_a_stop(looks: int) -> None:
    coming = Rig(max(1, looks), [DeviceAbsent("not yet")])
    assert wait_for_devices(coming, 5.0) is True
    assert coming.looks == max(1, looks)
    rig = Rig(10**9, [DeviceAbsent("no answer")])
    assert wait_for_devices(rig, 600.0, lambda: rig.looks >= looks) is False
    assert rig.looks == looks
