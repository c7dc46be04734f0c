"""Emulated TactTips whose motor or water is wrong in one thing, by the number of the duty that they break."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from common.framing import Frame
from sim_sensors.tacttip import TactTip
from tests.conformance.spoiled_module import (
    BORN_S,
    FINGER,
    WrongModules,
    over,
)
from tests.conformance.virtual_ends import VirtualModule


def no_water() -> VirtualModule:
    end = VirtualModule(TactTip(FINGER, BORN_S))
    end.hot_side_c = 40.0
    return end


def short_pulses() -> VirtualModule:
    module = TactTip(FINGER, BORN_S)
    over(module, "_pulse", lambda below, command, now_s: below(replace(command, pulse_us=command.pulse_us // 2), now_s))
    return VirtualModule(module)


def does_not_brake() -> VirtualModule:
    module = TactTip(FINGER, BORN_S)
    over(module, "_pulse", lambda below, command, now_s: below(command, now_s) if command.pulse_mv else None)
    return VirtualModule(module)


def repeats_its_pulse() -> VirtualModule:
    module = TactTip(FINGER, BORN_S)

    def pulse(below: Callable[..., None], command: Any, now_s: float) -> None:
        if now_s >= module._pulse_until_s:
            module._pulse_number = -1
        below(command, now_s)

    over(module, "_pulse", pulse)
    return VirtualModule(module)


def finishes_its_pulse() -> VirtualModule:
    module = TactTip(FINGER, BORN_S)
    over(module, "_pulse", lambda below, command, now_s: below(command, now_s) if command.pulse_us else None)
    return VirtualModule(module)


def slow_with_many() -> VirtualModule:
    """Of commands that come quickly it takes every twentieth."""
    module = TactTip(FINGER, BORN_S)
    last_s, quick = 0.0, 0

    def obey(below: Callable[..., None], frame: Frame, now_s: float) -> None:
        nonlocal last_s, quick
        quick = quick + 1 if now_s - last_s < 0.005 else 0
        last_s = now_s
        if quick < 10 or quick % 20 == 0:
            below(frame, now_s)

    over(module, "_obey", obey)
    return VirtualModule(module)


def little_water() -> VirtualModule:
    end = VirtualModule(TactTip(FINGER, BORN_S))

    def step(below: Callable[[float], None], drive: float) -> None:
        below(drive)
        end.hot_side_c += 0.02 * (20.0 - 15.0 * drive - end.hot_side_c)

    over(end.plate, "step", step)
    return end


WRONG_TACTTIPS: WrongModules = [
    ("T1", no_water),
    ("T2", short_pulses),
    ("T2", does_not_brake),
    ("T3", repeats_its_pulse),
    ("T4", finishes_its_pulse),
    ("T5", slow_with_many),
    ("T6", little_water),
]
