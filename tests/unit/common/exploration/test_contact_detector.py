"""Contact from a noisy force: soon, sure, and without chatter."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from common.exploration.contact_detector import AGREES_N, BOUNCE_S, CONTACT_OFF_N, CONTACT_ON_N, ContactDetector

TICK_S = 0.002
NOISE_N = 0.03
"""Three times that of the force sensors."""


def switches(contact: ContactDetector, force_n: np.ndarray) -> list[int]:
    """Ticks at which contact began or ended."""
    states = []
    for force in np.round(np.maximum(force_n, 0.0), 2).tolist():
        contact.step(TICK_S * len(states), force)
        states.append(contact.touching)
    return (np.flatnonzero(np.diff(states)) + 1).tolist()


def test_a_jump_is_detected_at_once_and_the_thresholds_differ() -> None:
    forces = np.repeat([0.0, 0.31, 0.16, 0.14, 0.29, 0.0], 50)
    began, ended = switches(ContactDetector(), forces)
    assert began == 50
    assert 150 < ended <= 150 + 5, "from 0.16 to 0.14 N is no jump: the mean of 10 ms"


@given(st.lists(st.floats(0.0, 1.0), min_size=1, max_size=200))
def test_a_force_far_beyond_a_threshold_is_detected_in_the_same_tick(forces: list[float]) -> None:
    contact = ContactDetector()
    for tick, force_n in enumerate(forces):
        contact.step(TICK_S * tick, force_n)
        if force_n >= CONTACT_ON_N + AGREES_N:
            assert contact.touching
        if force_n < CONTACT_OFF_N - AGREES_N + 0.01:
            assert not contact.touching
        assert min(forces) - 1e-9 <= contact.force_n <= max(forces) + 1e-9


def test_a_finger_that_hovers_never_touches() -> None:
    noise = NOISE_N * np.random.default_rng(1).standard_normal(150_000)
    assert switches(ContactDetector(), noise) == []


def test_a_grazing_finger_touches_once() -> None:
    time_s = TICK_S * np.arange(15_000)
    pressed = 0.33 - 0.10 * (1.0 - np.cos(2.0 * np.pi * time_s)) / 2.0
    for seed in range(10):
        noise = NOISE_N * np.random.default_rng(seed).standard_normal(len(time_s))
        assert len(switches(ContactDetector(), np.concatenate((np.zeros(50), pressed + noise[: len(pressed)])))) == 1


def test_contact_is_detected_within_5_ms_at_any_rise() -> None:
    late_s = []
    for seed in range(300):
        draw = np.random.default_rng(seed)
        rise_n_s = float(np.exp(draw.uniform(*np.log((8.0, 2000.0)))))
        crossed_s = draw.uniform(0.2, 0.202)
        force = np.maximum(0.0, CONTACT_ON_N + rise_n_s * (TICK_S * np.arange(200) - crossed_s)).clip(0.0, 2.0)
        first = switches(ContactDetector(), force + NOISE_N * draw.standard_normal(200))[0]
        late_s.append(TICK_S * first - crossed_s)
    assert np.mean(np.array(late_s) <= 0.005) >= 0.99
    assert max(late_s) <= 0.007


def test_a_bounce_begins_no_contact() -> None:
    for away_s, begun in ((0.5 * BOUNCE_S, 1), (2.0 * BOUNCE_S, 2)):
        contact, began, ended, tick = ContactDetector(), 0, 0, 0
        for force_n, seconds in ((0.0, 0.1), (1.0, 0.02), (0.0, away_s), (1.0, 0.1)):
            for _ in range(round(seconds / TICK_S)):
                contact.step(TICK_S * tick, force_n)
                tick += 1
                began += contact.began
                ended += contact.ended
        assert (began, ended) == (begun, 1)
        assert contact.touching
