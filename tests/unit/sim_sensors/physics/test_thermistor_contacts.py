"""Thermistors that come off their plates, and what they read then."""

import numpy as np
import pytest

from sim_sensors.physics.thermistor_contacts import LEAST_CONTACT, ThermistorContacts

PLATE_C, ROOM_C = np.array([33.0, 43.0]), 23.0


def test_a_sound_thermistor_reads_its_plate() -> None:
    assert ThermistorContacts(2).read(1.0, PLATE_C, ROOM_C) == pytest.approx(PLATE_C)


def test_a_loose_one_reads_less_and_less_and_keeps_the_rest_of_its_contact() -> None:
    contacts = ThermistorContacts(2)
    contacts.lost_per_s[1] = 0.2
    reads_c = [contacts.read(1.0, PLATE_C, ROOM_C)[1] for _ in range(5)]
    assert reads_c == pytest.approx([39.0, 35.0, 31.0, 31.0, 31.0])
    assert (reads_c[-1] - ROOM_C) / (PLATE_C[1] - ROOM_C) == pytest.approx(LEAST_CONTACT)


@pytest.mark.parametrize("also", [0.0, 0.1])
def test_a_mended_one_is_whole_again_and_loosens_from_there(also: float) -> None:
    contacts = ThermistorContacts(2)
    contacts.lost_per_s[:] = also, 0.2
    contacts.read(1.0, PLATE_C, ROOM_C)
    contacts.lost_per_s[1] = 0.0
    assert contacts.read(1.0, PLATE_C, ROOM_C)[1] == pytest.approx(PLATE_C[1])
    contacts.lost_per_s[1] = 0.2
    assert contacts.read(1.0, PLATE_C, ROOM_C)[1] == pytest.approx(39.0)
