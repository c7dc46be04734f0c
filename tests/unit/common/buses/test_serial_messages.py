from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.buses.serial_messages import (
    BadPayload,
    DeviceKind,
    HeaterCommand,
    Identity,
    PatientSwitchState,
    TactTipCommand,
    TactTipState,
    TextureSamples,
    ThermalReading,
)

LENGTHS = {
    Identity: 22,
    ThermalReading: 11,
    HeaterCommand: 2,
    TactTipCommand: 9,
    TactTipState: 13,
    PatientSwitchState: 5,
}
KINDS: list[Any] = [*LENGTHS, TextureSamples]
OFF: dict[Any, tuple[int, ...]] = {ThermalReading: (0,), TactTipState: (0, 0)}
"""The drives that a report ends with."""
drive = st.integers(-1000, 1000)
counts_12 = st.integers(0, 4095)
u32 = st.integers(0, 2**32 - 1)


@given(st.sampled_from(KINDS), st.binary(max_size=40))
def test_any_payload_raises_nothing_but_bad_payload(kind: Any, payload: bytes) -> None:
    try:
        message = kind.decode(payload)
    except BadPayload:
        return
    if kind is not Identity:  # a serial number may be padded in more ways than one
        assert message.encode() == payload


@pytest.mark.parametrize(("kind", "length"), LENGTHS.items())
def test_a_wrong_length_is_refused(kind: Any, length: int) -> None:
    for wrong in (0, length - 1, length + 1):
        with pytest.raises(BadPayload, match=f"{wrong} bytes, expected {length}"):
            kind.decode(bytes(wrong))


@given(st.integers(0, 3000), drive, st.integers(0, 3000), st.integers(0, 50_000), st.integers(0, 255))
def test_commands_come_back(motor_mv: int, permille: int, pulse_mv: int, pulse_us: int, number: int) -> None:
    for command in (HeaterCommand(permille), TactTipCommand(motor_mv, permille, pulse_mv, pulse_us, number)):
        assert type(command).decode(command.encode()) == command


@given(u32, counts_12, counts_12, st.integers(0, 255), st.integers(0, 3000), drive)
def test_reports_come_back_and_device_time_wraps(
    time_us: int, first: int, second: int, flags: int, motor_mv: int, permille: int
) -> None:
    measured = (first, second, flags)
    for report in (
        ThermalReading(time_us, *measured, permille),
        TactTipState(time_us, *measured, motor_mv, permille),
        TextureSamples(time_us, bytes(20)),
    ):
        assert type(report).decode(report.encode()) == report
        wrapped = replace(report, device_time_us=time_us + 2**32)
        assert type(report).decode(wrapped.encode()) == report


@pytest.mark.parametrize(
    "report", [ThermalReading(0, 0, 0, 0, 1001), TactTipState(0, 0, 0, 0, 3001, 0), TactTipState(0, 0, 0, 0, 0, -1001)]
)
def test_an_impossible_drive_in_a_report_is_refused(report: Any) -> None:
    with pytest.raises(BadPayload, match="outside"):
        type(report).decode(report.encode())


@pytest.mark.parametrize(
    "command",
    [
        HeaterCommand(1001),
        HeaterCommand(-1001),
        TactTipCommand(3001, 0),
        TactTipCommand(0, 1001),
        TactTipCommand(0, 0, 3001, 1),
        TactTipCommand(0, 0, 0, 50_001),
    ],
)
def test_a_drive_beyond_full_is_neither_sent_nor_taken(command: HeaterCommand | TactTipCommand) -> None:
    with pytest.raises(ValueError, match="outside"):
        command.encode()
    fields = [getattr(command, name) for name in command.__slots__]
    with pytest.raises(BadPayload, match="outside"):
        type(command).decode(command.LAYOUT.pack(*fields))


def test_a_negative_motor_voltage_is_not_sent() -> None:
    with pytest.raises(ValueError, match="motor voltage -1 mV"):
        TactTipCommand(-1, 0).encode()


@pytest.mark.parametrize("kind", [ThermalReading, TactTipState])
def test_counts_beyond_12_bits_are_refused(kind: Any) -> None:
    for pair in ((4096, 0), (0, 4096)):
        with pytest.raises(BadPayload, match="12 bits"):
            kind.decode(kind(0, *pair, 0, *OFF[kind]).encode())


@pytest.mark.parametrize("sample", [2048, -2049, 32767])
def test_samples_beyond_12_bits_are_refused(sample: int) -> None:
    counts = (0).to_bytes(2, "little") + sample.to_bytes(2, "little", signed=True)
    with pytest.raises(BadPayload, match="12 bits"):
        TextureSamples.decode(TextureSamples(0, counts).encode())


def test_the_announced_count_of_samples_must_follow() -> None:
    good = TextureSamples(0, bytes(20)).encode()
    for payload in (good[:-1], good[:-2], good + b"\0\0", good[:4]):
        with pytest.raises(BadPayload, match="texture samples"):
            TextureSamples.decode(payload)


@pytest.mark.parametrize(
    ("position", "value", "message"),
    [(0, 0, "0 is not a valid"), (0, 5, "5 is not a valid"), (1, 5, "finger"), (2, 200, "ascii")],
)
def test_a_wrong_identity_is_refused(position: int, value: int, message: str) -> None:
    payload = bytearray(Identity(DeviceKind.TACTTIP, 0, "TT1", 1, 100, 8.0, 80.0).encode())
    payload[position] = value
    with pytest.raises(BadPayload, match=message):
        Identity.decode(bytes(payload))


def test_a_contact_is_open_or_closed() -> None:
    with pytest.raises(BadPayload, match="contact 2 is neither 0 nor 1"):
        PatientSwitchState.decode(bytes((0, 0, 0, 0, 2)))


@given(u32, st.booleans(), st.none() | st.integers(0, 1000))
def test_a_switch_comes_back_with_and_without_a_slider(time_us: int, closed: bool, pain: int | None) -> None:
    state = PatientSwitchState(time_us, closed, pain)
    assert PatientSwitchState.decode(state.encode()) == state
    assert len(state.encode()) == (5 if pain is None else 7)


@given(st.binary(min_size=7, max_size=7))
def test_a_switch_with_a_slider_decodes_or_is_refused(payload: bytes) -> None:
    try:
        state = PatientSwitchState.decode(payload)
    except BadPayload:
        return
    assert state.pain_permille is not None
    assert 0 <= state.pain_permille <= 1000
    assert state.encode() == payload


@pytest.mark.parametrize("pain", [-1, 1001])
def test_a_slider_beyond_its_end_is_neither_sent_nor_taken(pain: int) -> None:
    with pytest.raises(ValueError, match="pain slider"):
        PatientSwitchState(0, True, pain).encode()
    with pytest.raises(BadPayload, match="pain slider"):
        PatientSwitchState.decode(PatientSwitchState.WITH_SLIDER.pack(0, 1, pain & 0xFFFF))
