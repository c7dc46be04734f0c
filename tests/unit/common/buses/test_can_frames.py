import contextlib
import math

import cantools
import pytest
from cantools.database.can import Database
from hypothesis import given
from hypothesis import strategies as st

from common.buses.can_frames import BadFrame, CanSignals, FrameReceiver, FrameSender, database
from common.fingers import FINGERS

MESSAGES = {message.name: message for message in database().messages}
PACKINGS = {name: CanSignals(message) for name, message in MESSAGES.items()}
OWN = ("counter", "crc")
FRAMES = list(MESSAGES)
WITH_CRC = [m.name for m in database().messages if any(s.name == "crc" for s in m.signals)]
names = st.sampled_from(FRAMES)
BITS_OF_8_BYTES = 135
"""Classic CAN, 11 bit identifier, 8 data bytes, worst case of bit stuffing."""


def some_values(name: str, value: float = 0.0) -> dict[str, float]:
    signals = database().get_message_by_name(name).signals
    return {s.name: value for s in signals if s.name not in ("counter", "crc")}


@given(names, st.data())
def test_values_come_back_within_half_a_step_clipped_to_the_range(name: str, data: st.DataObject) -> None:
    message = database().get_message_by_name(name)
    sent = {key: data.draw(st.floats(-1e6, 1e6) | st.floats(-12, 12)) for key in some_values(name)}
    received = FrameReceiver(name).decode(bytes(FrameSender(name).encode(sent).data))
    for key, value in received.items():
        signal = message.get_signal_by_name(key)
        clipped = min(max(sent[key], float(signal.minimum or 0)), float(signal.maximum or 0))
        assert abs(value - clipped) <= 0.5001 * float(signal.scale)


@pytest.mark.parametrize("name", FRAMES)
def test_every_bit_pattern_is_in_range(name: str) -> None:
    for signal in database().get_message_by_name(name).signals:
        low = -(2 ** (signal.length - 1)) if signal.is_signed else 0
        high = low + 2**signal.length - 1
        assert signal.minimum == pytest.approx(low * signal.scale)
        assert signal.maximum == pytest.approx(high * signal.scale)
        assert signal.byte_order == "little_endian"


@pytest.mark.parametrize("name", FRAMES)
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_nan_and_infinity_are_not_sent(name: str, bad: float) -> None:
    values = some_values(name)
    last = list(values)[-1]
    with pytest.raises(ValueError, match=rf"{name}\.{last}"):
        FrameSender(name).encode({**values, last: bad})
    del values[last]
    with pytest.raises(ValueError, match="no value to send"):
        FrameSender(name).encode(values)


@pytest.mark.parametrize("name", FRAMES)
def test_the_counter_turns_and_a_repeated_frame_is_refused(name: str) -> None:
    sender, receiver = FrameSender(name), FrameReceiver(name)
    for _ in range(40):
        data = bytes(sender.encode(some_values(name)).data)
        receiver.decode(data)
        with pytest.raises(BadFrame, match="stands still"):
            receiver.decode(data)
    assert receiver.refused == 40


@pytest.mark.parametrize("name", WITH_CRC)
def test_one_wrong_byte_anywhere_is_refused_and_the_next_good_frame_taken(name: str) -> None:
    sender, receiver = FrameSender(name), FrameReceiver(name)
    data = bytes(sender.encode(some_values(name, 1.0)).data)
    escaped = 0
    for position in range(8):
        for damage in range(1, 256):
            broken = bytearray(data)
            broken[position] ^= damage
            with contextlib.suppress(BadFrame):
                FrameReceiver(name).decode(bytes(broken))
                escaped += 1
    # Half of a 16 bit CRC sees one in 256 patterns wrong at worst; of single bits it misses none (below).
    assert escaped <= 8 * 255 // 100
    assert receiver.decode(data) == pytest.approx(some_values(name, 1.0))


@given(st.sampled_from(WITH_CRC), st.floats(-10, 10), st.integers(0, 63))
def test_one_wrong_bit_is_always_refused(name: str, value: float, bit: int) -> None:
    data = int.from_bytes(FrameSender(name).encode(some_values(name, value)).data, "little") ^ (1 << bit)
    with pytest.raises(BadFrame, match="CRC"):
        FrameReceiver(name).decode(data.to_bytes(8, "little"))


def test_a_frame_of_another_kind_or_of_a_wrong_length_is_refused() -> None:
    data = bytes(FrameSender("HandPose").encode({"x": 1.0, "y": 2.0}).data)
    for other in ("HandSetpoint", "HandPoseMeasured"):
        with pytest.raises(BadFrame, match="CRC"):
            FrameReceiver(other).decode(data)
    for length in (0, 7, 9):
        with pytest.raises(BadFrame, match=f"{length} bytes"):
            FrameReceiver("FingerForces").decode(bytes(length))


@given(names, st.binary(min_size=8, max_size=8))
def test_any_bytes_raise_nothing_but_bad_frame(name: str, data: bytes) -> None:
    try:
        values = FrameReceiver(name).decode(data)
    except BadFrame:
        return
    assert set(values) == set(some_values(name))
    assert all(math.isfinite(value) for value in values.values())


@pytest.mark.parametrize(
    ("site", "device", "loop_hz", "percent"),
    [
        ("remote_site", "telemanipulator", 250, 28.35),
        ("operator_site", "exoskeleton", 500, 21.6),
        ("remote_site", "telemanipulator", 1000, 48.6),
        ("operator_site", "exoskeleton", 1000, 28.35),
    ],
)
def test_the_bus_load_agrees_with_the_document_and_is_below_half(
    site: str, device: str, loop_hz: int, percent: float
) -> None:
    on_bus = [m for m in database().messages if {site, device} & set(m.senders)]
    assert all(m.length == 8 and not m.is_extended_frame for m in on_bus)
    rates = [loop_hz if site in m.senders else 100 if m.name.endswith("State") else 500 for m in on_bus]
    bits = sum(BITS_OF_8_BYTES * rate_hz for rate_hz in rates)
    assert bits / 1e6 * 100 == pytest.approx(percent)
    assert bits < 0.5e6


def test_every_frame_of_five_values_names_all_fingers() -> None:
    fives = [m for m in database().messages if any(s.name == "thumb" for s in m.signals)]
    assert len(fives) == 6
    for message in fives:
        by_start = sorted((s.start, s.name) for s in message.signals if s.name in FINGERS)
        assert tuple(name for _, name in by_start) == FINGERS


@given(st.sampled_from(sorted(MESSAGES)), st.integers(0, 15), st.data())
def test_packing_agrees_with_cantools(name: str, counter: int, data: st.DataObject) -> None:
    signals = [signal for signal in MESSAGES[name].signals if signal.name not in OWN]
    values = {s.name: data.draw(st.floats(-20.0, 20.0) | st.floats(-1e9, 1e9), s.name) for s in signals}
    clipped = {s.name: min(max(values[s.name], float(s.minimum or 0)), float(s.maximum or 0)) for s in signals}
    crc = {"crc": 0} if PACKINGS[name].has_crc else {}
    assert PACKINGS[name].pack(values, counter) == MESSAGES[name].encode(
        {**clipped, "counter": counter, **crc}, strict=False
    )


@given(st.sampled_from(sorted(MESSAGES)), st.binary(min_size=8, max_size=8))
def test_unpacking_agrees_with_cantools(name: str, data: bytes) -> None:
    decoded = MESSAGES[name].decode(data)
    assert isinstance(decoded, dict)
    counter = decoded["counter"]
    assert PACKINGS[name].unpack(data) == ({key: value for key, value in decoded.items() if key not in OWN}, counter)


@pytest.mark.parametrize("signal", ["0|16@0- (0.02,0)", "0|16@1- (0.02,5)"])
def test_an_unsupported_description_is_refused(signal: str) -> None:
    described = cantools.database.load_string(
        f'BO_ 256 Pose: 8 it\n SG_ x : {signal} [-1|1] "mm" us\n SG_ counter : 48|4@1+ (1,0) [0|15] "" us\n', "dbc"
    )
    assert isinstance(described, Database)
    with pytest.raises(ValueError, match=r"Pose\.x: an integer in Intel byte order without offset is needed"):
        CanSignals(described.messages[0])
