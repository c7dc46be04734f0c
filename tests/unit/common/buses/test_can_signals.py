"""The quick packing is that of cantools, bit for bit."""

import cantools
import pytest
from cantools.database.can import Database
from hypothesis import given
from hypothesis import strategies as st

from common.buses.can_frames import database
from common.buses.can_signals import CanSignals

MESSAGES = {message.name: message for message in database().messages}
PACKINGS = {name: CanSignals(message) for name, message in MESSAGES.items()}
OWN = ("counter", "crc")


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
