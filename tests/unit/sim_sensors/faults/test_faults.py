"""Faults on command, at the devices of both sides: what each does, that it ends, and that nonsense changes nothing."""

import socket
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.buses.serial_messages import MessageId, TactTipCommand, encode_frame
from common.buses.thermometry import COUNT_MAX
from common.config.simulation_models import SimOperatorConfig
from common.fingers import FINGERS
from common.limits import MODULE_TIMEOUT_S
from sim_sensors.faults.faults import Fault, Faults
from sim_sensors.operator_devices import OperatorDevices
from sim_sensors.physics.finger_plate import ROOM_C, WATER_C
from sim_sensors.physics.fingertip import HIGH_Z_M
from sim_sensors.physics.ssr_converter import celsius_of
from sim_sensors.ports.select_loop import SelectLoop
from sim_sensors.ports.simulation_loop import STEP_S
from sim_sensors.remote_devices import RemoteDevices
from tests.ports import free_port
from tests.unit.sim_sensors.stepped import START_S, advance, reported, send_hand
from tests.waiting import wait_until

WRONG_WORDS = {
    "": ["", "explode", "bus_off can", "babble can", "plug index tacttip"],
    "piezo": ["index", "index wet", "thumb cut"],
    "force": ["index", "index stuck"],
    "disobey": ["away", "thumb drift"],
    "unplug": ["", "nose", "index", "index tacttip now", "thumb tacttip"],
    "encoder": ["index", "index open", "thumb stuck"],
    "damage": ["can", "can crc", "can crc 0", "can crc 1.1", "can crc nan", "can bits 0.5"],
    "stuck": ["index", "index full", "index 1001", "index nan"],
    "thermistor": ["index", "index wet", "thumb open"],
    "slider": ["", "half", "-1", "65536", "1_0", "1e2"],
    "motor": ["index", "index 3001", "index -1", "index full"],
    "shift": ["", "5", "0 0 51", "0 0 nan", "0 0 z"],
    "hang": ["", "0", "-1", "nan", "1e9"],
    "mend": ["nose", "unplug index tacttip"],
    "water": ["", "thumb", "index off"],
    "reverse": ["", "thumb", "index -1"],
    "loosen": ["", "index", "index 0", "index 1.1", "index nan", "thumb 0.1"],
}
NONSENSE = [f"{word} {rest}".strip() for word, wrong in WRONG_WORDS.items() for rest in wrong]


@pytest.mark.parametrize("site", ["remote", "operator"])
def test_nonsense_is_one_line_of_error_and_changes_nothing(site: str, request: pytest.FixtureRequest) -> None:
    faults = request.getfixturevalue(site).faults
    faults.apply("deafen can")
    for line in NONSENSE:
        with pytest.raises(ValueError, match=r".+") as error:
            faults.apply(line)
        assert "\n" not in str(error.value)
        assert faults.in_force == ["deafen can"], line


def test_an_error_says_what_there_is_to_say(remote: RemoteDevices) -> None:
    with pytest.raises(ValueError, match=r"use unplug DEVICE, .*thermistor FINGER open\|short\|frozen, .*disobey"):
        remote.faults.apply("help")
    with pytest.raises(ValueError, match="unplug DEVICE: unknown target 'index nose'; known: index texture"):
        remote.faults.apply("unplug index nose")
    with pytest.raises(ValueError, match="'wet' is neither saturated, clipped, cut nor loose"):
        remote.faults.apply("piezo index wet")
    with pytest.raises(ValueError, match=r"disobey \[FINGER\|drift\]: 'away' is not drift"):
        remote.faults.apply("disobey away")
    with pytest.raises(ValueError, match="no fault 'water'"):
        remote.faults.apply("water index")
    with pytest.raises(ValueError, match="'1001' is not a whole number of thousandths, -1000 to 1000"):
        remote.faults.apply("stuck index 1001")
    with pytest.raises(ValueError, match="in force: nothing"):
        remote.faults.apply("mend disobey")


def test_faults_are_listed_and_ended_by_name_or_all_at_once(remote: RemoteDevices) -> None:
    assert remote.faults.apply("disobey  drift") == "disobey"
    assert remote.faults.apply("thermistor index open") == "disobey, thermistor index"
    assert remote.faults.apply("thermistor index short") == "disobey, thermistor index"
    assert remote.faults.apply("unplug can") == "disobey, thermistor index, unplug can"
    assert remote.figures()["faults"] == ["disobey", "thermistor index", "unplug can"]
    assert remote.faults.apply("mend thermistor index") == "disobey, unplug can"
    assert remote.faults.apply("piezo index loose") == "disobey, unplug can, piezo index"
    assert remote.piezos["index"].fault == "loose"
    assert remote.faults.apply("mend piezo index") == "disobey, unplug can"
    assert remote.piezos["index"].fault is None
    assert remote.faults.apply("plug can") == "disobey"
    assert remote.faults.apply("mend") == ""
    assert remote.faults.apply("mend") == ""


class Lamp:
    """Something that can be broken in two ways."""

    def __init__(self) -> None:
        self.broken: set[str] = set()


COMMANDS = st.sampled_from(
    ["crack a", "crack b", "burn a", "burn b now", "mend", "mend crack a", "mend burn a", "mend burn b", "crack", "x"]
)


@given(st.lists(COMMANDS, max_size=30))
def test_what_is_listed_as_in_force_is_what_is_broken(lines: list[str]) -> None:
    lamps = {"a": Lamp(), "b": Lamp()}

    def break_it(kind: str) -> Fault[Lamp]:
        def begin(lamp: Lamp, text: str) -> object:
            if text:
                raise ValueError("too many words")
            lamp.broken.add(kind)
            return lambda: lamp.broken.discard(kind)

        return Fault("LAMP", lamps, begin)  # type: ignore[arg-type]

    faults = Faults({kind: break_it(kind) for kind in ("crack", "burn")})
    for line in lines:
        with suppress(ValueError):
            faults.apply(line)
        broken = {f"{kind} {name}" for name, lamp in lamps.items() for kind in lamp.broken}
        assert set(faults.in_force) == broken
    faults.apply("mend")
    assert not any(lamp.broken for lamp in lamps.values())


@pytest.mark.parametrize(("fault", "counts"), [("open", COUNT_MAX), ("short", 0)])
def test_a_broken_thermistor_changes_what_its_converter_reads_and_nothing_else(
    fault: str, counts: int, remote: RemoteDevices, operator: OperatorDevices
) -> None:
    for devices, module in ((remote, remote.thermal["index"]), (operator, operator.modules["index"])):
        sound = module.plate_counts
        plates_c = np.array(remote.world.plate_c), operator.plates.plate_c.copy()
        devices.faults.apply(f"thermistor index {fault}")
        advance(devices, range(1, 11))
        assert module.plate_counts == counts
        assert remote.world.plate_c == pytest.approx(plates_c[0], abs=0.1)
        assert operator.plates.plate_c == pytest.approx(plates_c[1], abs=0.1)
        devices.faults.apply("mend thermistor index")
        advance(devices, range(11, 21))
        assert module.plate_counts == pytest.approx(sound, abs=20)


def test_a_frozen_thermistor_misses_what_the_plate_does(remote: RemoteDevices) -> None:
    module = remote.thermal["index"]
    advance(remote, range(1, 11))
    frozen = module.plate_counts
    remote.faults.apply("thermistor index frozen")
    remote.faults.apply("stuck index 1000")
    for step in range(11, 600):
        remote.step(START_S + step * STEP_S)
        assert module.plate_counts == frozen
    assert remote.world.plate_c[1] > remote.world.plate_c[0] + 1.0
    remote.faults.apply("mend")
    advance(remote, range(600, 611))
    assert module.plate_counts > frozen + 30


def test_a_robot_that_disobeys_stays_where_it_is_and_says_so(remote: RemoteDevices) -> None:
    send_hand(remote, range(1, 300), x_m=-0.1)
    assert remote.world.x_m == pytest.approx(-0.1, abs=1e-4)
    remote.faults.apply("disobey")
    send_hand(remote, range(300, 600), x_m=-0.2)
    assert remote.world.x_m == pytest.approx(-0.1, abs=1e-4)
    assert reported(remote.robot, "HandPoseMeasured")[0]["x"] == pytest.approx(1e3 * remote.world.x_m, abs=0.02)
    remote.faults.apply("mend disobey")
    send_hand(remote, range(600, 900), x_m=-0.2)
    assert remote.world.x_m == pytest.approx(-0.2, abs=1e-4)


def test_a_robot_that_drifts_goes_its_own_way_even_without_set_points(remote: RemoteDevices) -> None:
    send_hand(remote, range(1, 300), x_m=-0.1)
    remote.faults.apply("disobey drift")
    advance(remote, range(300, 800))
    assert remote.world.x_m == pytest.approx(-0.1 + 0.02 * 500 * STEP_S, abs=2e-3)


@pytest.mark.long
def test_a_module_without_water_warms_its_hot_side_by_cooling_its_plate_and_water_ends_that(
    operator: OperatorDevices,
) -> None:
    index = FINGERS.index("index")
    operator.faults.apply("stuck index -1000")
    operator.faults.apply("water index")
    advance(operator, range(1, 5001))
    hot_side_c = operator.plates.hot_side_c.copy()
    assert hot_side_c[index] > WATER_C + 2.0
    assert np.delete(hot_side_c, index) == pytest.approx([WATER_C] * 4, abs=0.1)
    operator.faults.apply("mend water index")
    advance(operator, range(5001, 15_001))
    assert operator.plates.hot_side_c[index] < WATER_C + 1.5


def test_reversed_peltiers_do_the_opposite_while_the_module_reports_what_it_was_asked(
    operator: OperatorDevices,
) -> None:
    index, start_c = FINGERS.index("index"), operator.plates.plate_c.copy()
    operator.faults.apply("reverse index")
    operator.faults.apply("stuck index 1000")
    advance(operator, range(1, 501))
    assert operator.plates.plate_c[index] < start_c[index] - 2.0
    assert operator.modules["index"].drive_permille == 1000
    operator.faults.apply("mend reverse index")
    advance(operator, range(501, 1001))
    assert operator.plates.plate_c[index] > start_c[index] + 0.5


def test_a_thermistor_that_comes_off_reads_too_little_until_it_is_mended(operator: OperatorDevices) -> None:
    index, plates = FINGERS.index("index"), operator.plates
    operator.faults.apply("loosen index 0.05")
    advance(operator, range(1, 2001))
    too_little_k = plates.plate_c - plates.ntc_c
    assert too_little_k[index] == pytest.approx(0.2 * (plates.plate_c[index] - ROOM_C), abs=0.1)
    assert np.delete(too_little_k, index) == pytest.approx([0.0] * 4, abs=0.1)
    operator.faults.apply("mend loosen index")
    advance(operator, range(2001, 2101))
    assert plates.ntc_c[index] == pytest.approx(plates.plate_c[index], abs=0.1)


def test_a_thermal_sensor_that_comes_off_reads_too_little_until_it_is_mended(remote: RemoteDevices) -> None:
    index, world = FINGERS.index("index"), remote.world

    def too_little_k() -> np.ndarray:
        """After four seconds in air, with the heaters off."""
        for _ in range(round(4.0 / STEP_S)):
            world.step(STEP_S, 0.0, 0.0, np.full(5, HIGH_Z_M), np.zeros(5))
        return np.asarray(world.plate_c - celsius_of(world.ssr_counts()))

    world.plate_c[:] = 34.0
    remote.faults.apply("loosen index 0.2")
    read_k = too_little_k()
    assert read_k[index] == pytest.approx(0.6 * (world.plate_c[index] - world.scene.ambient_c), abs=0.5)
    assert np.delete(read_k, index) == pytest.approx([0.0] * 4, abs=0.5)
    remote.faults.apply("mend loosen index")
    assert too_little_k()[index] == pytest.approx(0.0, abs=0.5)


def test_the_process_hangs_at_its_next_step_so_that_its_client_is_answered(operator: OperatorDevices) -> None:
    slept: list[float] = []
    operator.hang.sleep = slept.append
    assert operator.faults.apply("hang 2.5") == ""
    assert slept == []
    advance(operator, range(1, 4))
    assert slept == [2.5]


def test_a_silent_modules_own_time_out_still_acts(operator: OperatorDevices) -> None:
    module = operator.modules["index"]
    module.feed(encode_frame(MessageId.TACTTIP_COMMAND, 0, TactTipCommand(1000, 0).encode()), START_S)
    operator.faults.apply("silence index tacttip")
    within = round(MODULE_TIMEOUT_S / STEP_S)
    advance(operator, range(1, within))
    assert module.motor_mv == 1000
    advance(operator, range(within, within + 2))
    assert module.motor_mv == 0


def test_a_simulation_takes_commands_at_its_fault_port_and_nobody_can_without(stopped: SelectLoop) -> None:
    port = free_port()
    config = SimOperatorConfig(
        fingers=("index",), tacttip={"index": "tcp:127.0.0.1:0"}, can_port=free_port(), fault_port=port
    )
    devices = OperatorDevices(config, stopped)
    with socket.create_connection(("127.0.0.1", port)) as client:
        client.sendall(b"unplug index tacttip\n")
        client.settimeout(0.0)
        wait_until(lambda: stopped.serve(0.0) or devices.faults.in_force)  # type: ignore[func-returns-value]
        assert devices.faults.in_force == ["unplug index tacttip"]
        assert client.recv(100).startswith(b"ok 100000000000 unplug index tacttip\n")
    devices.close()
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.1", port))


def test_a_motors_driver_is_stuck_at_a_voltage_and_reports_it(operator: OperatorDevices) -> None:
    module = operator.modules["index"]
    operator.faults.apply("motor index 2999")
    advance(operator, range(1, 10))
    assert (module.motor_mv, module.motor_v(START_S, START_S + 1.0)) == (2999, 2.999)
    operator.faults.apply("mend motor index")
    advance(operator, range(10, 20))
    assert (module.motor_mv, module.motor_v(START_S, START_S + 1.0)) == (0, 0.0)
