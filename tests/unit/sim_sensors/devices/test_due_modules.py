"""A module that is looked at only when something is due says and does the same as one that is looked at always."""

import math

import numpy as np
import pytest

from common.buses.serial_messages import HeaterCommand, MessageId, TactTipCommand, encode_frame
from sim_sensors.devices.tacttip import TactTip
from sim_sensors.devices.thermal_sensor import ThermalSensor

STEP_S = 0.001


def commands(kind: type[TactTip | ThermalSensor], seed: int) -> dict[int, bytes]:
    """Commands by step: some close to each other, some after the module's time-out."""
    chance, at, found = np.random.default_rng(seed), 0, dict[int, bytes]()
    for number in range(60):
        at += int(chance.choice((3, 10, 40, 130)))
        drive = int(chance.integers(-1000, 1000))
        if kind is ThermalSensor:
            found[at] = encode_frame(MessageId.HEATER_COMMAND, number & 0xFF, HeaterCommand(drive).encode())
        else:
            pulse_us = int(chance.choice((0, 4_500, 30_000)))
            motor_mv = int(chance.choice((0, 1000)))
            command = TactTipCommand(motor_mv, drive, 2000, pulse_us, number).encode()
            found[at] = encode_frame(MessageId.TACTTIP_COMMAND, number & 0xFF, command)
    return found


@pytest.mark.parametrize("kind", [TactTip, ThermalSensor])
@pytest.mark.parametrize("seed", range(5))
def test_it_misses_nothing(kind: type[TactTip | ThermalSensor], seed: int) -> None:
    always, seldom = kind(0), kind(0)
    sent, looks = commands(kind, seed), 0
    for step in range(max(sent) + 300):
        now_s = step * STEP_S
        for module in (always, seldom):
            module.measure(2000, 2000)
            if step in sent:
                module.feed(sent[step], now_s)
        always.due_s = -math.inf
        looks += now_s >= seldom.due_s
        assert seldom.take_output(now_s) == always.take_output(now_s)
        if isinstance(always, TactTip) and isinstance(seldom, TactTip):
            assert seldom.motor_mv == always.motor_mv
            assert seldom.motor_v(now_s - STEP_S, now_s) == always.motor_v(now_s - STEP_S, now_s)
            assert seldom.drive_permille == always.drive_permille
            assert seldom.take_motor_switches() == always.take_motor_switches()
    assert looks < 0.2 * step
