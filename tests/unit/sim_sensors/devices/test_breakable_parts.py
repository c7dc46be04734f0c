import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.buses.serial_messages import FrameReader, encode_frame
from sim_sensors.devices.breakable_parts import Babble, Piezo, Place, Servos

BAUD = 921_600
STEP_S = 0.002


def test_a_piezo_gives_what_its_fault_makes_it_give_and_is_sound_again_afterwards() -> None:
    piezo, counts = Piezo(), np.array([-300, 0, 5, 2000], np.int16)
    assert piezo.read(counts).tolist() == counts.tolist()
    piezo.fault = "saturated"
    assert piezo.read(counts).tolist() == [2047] * 4
    piezo.fault = "clipped"
    assert piezo.read(counts).tolist() == [-2048, 0, 150, 2047]
    piezo.fault = "cut"
    assert piezo.read(counts).tolist() == [0] * 4
    piezo.fault = "loose"
    noise = piezo.read(np.full(1000, 500, np.int16))
    assert abs(noise.mean()) < 0.5
    assert 1.0 < noise.std() < 2.5
    piezo.fault = None
    assert piezo.read(counts).tolist() == counts.tolist()


def place(x_m: float, z_m: float) -> Place:
    return x_m, -0.02, np.full(5, z_m)


def said(found: Place) -> tuple[float, float, list[float]]:
    return found[0], found[1], found[2].tolist()


def test_dead_servos_hold_what_they_followed_last_whatever_is_asked() -> None:
    servos = Servos()
    asked = place(0.1, 0.003)
    assert said(servos.setpoint_m(1.0, asked)) == said(asked)
    servos.disobey()
    asked[2][:] = 0.0  # the caller's array is its own
    for now_s in (1.002, 3.0):
        assert said(servos.setpoint_m(now_s, place(0.2, 0.001))) == said(place(0.1, 0.003))
    servos.mend()
    assert said(servos.setpoint_m(3.1, place(0.2, 0.001))) == said(place(0.2, 0.001))


def test_drifting_servos_leave_along_x_at_their_speed_from_where_they_were() -> None:
    servos = Servos()
    servos.setpoint_m(10.0, place(0.1, 0.003))
    servos.disobey(drift_m_s=0.02)
    for step in range(1, 1251):
        found = servos.setpoint_m(10.0 + step * STEP_S, place(0.3, 0.0))
    assert found[0] == pytest.approx(0.15)
    assert said(found)[1:] == said(place(0.1, 0.003))[1:]
    servos.disobey()  # and stays there
    assert said(servos.setpoint_m(20.0, place(0.3, 0.0))) == said(found)


@pytest.mark.long
@given(st.lists(st.binary(min_size=0, max_size=40), min_size=20, max_size=60))
def test_babble_fills_its_line_and_no_more_and_leaves_every_frame_whole(payloads: list[bytes]) -> None:
    babble, reader, carried, found = Babble(BAUD), FrameReader(), 0, []
    babble.mix(0.0, b"")
    for n, payload in enumerate(payloads, start=1):
        frame = encode_frame(0x20, n & 0xFF, payload) if payload else b""
        mixed = babble.mix(n * STEP_S, frame)
        carried += len(mixed)
        found += [f.payload for f in reader.feed(mixed) if f.message_id == 0x20]
    room = len(payloads) * STEP_S * BAUD / 10
    assert 0.98 * room <= carried <= room
    assert found == [payload for payload in payloads if payload]
    assert reader.damaged > 0


def test_babble_does_not_make_up_for_a_long_pause() -> None:
    babble = Babble(BAUD)
    babble.mix(0.0, b"")
    assert len(babble.mix(100.0, b"")) <= 0.05 * BAUD / 10
    assert babble.mix(100.0, b"frame\0") == b"frame\0"
