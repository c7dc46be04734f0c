"""Touches of the second world: reproducible, converged, and in the order that physics demands."""

from dataclasses import replace

import numpy as np
import pytest

from studies.second_world import axisymmetric, touches
from studies.second_world.ranges import draw_sensor
from studies.second_world.touches import Kind, Objects, simulate_touches


def fallen_k(kind: Kind, name: str, at_s: float) -> float:
    """Return how far the reading has fallen at a time after contact, K."""
    (hand,) = simulate_touches(kind, name, 1, (0,), seconds=at_s + 0.5, objects=Objects("ambient", (0.0, 0.0)))
    (touch,) = hand.fingers
    return touch.start_c - float(touch.trace.sensor_c[touch.first + round(100 * at_s)])


def quiet(seed: int) -> Kind:
    """Return a kind without noise, so that readings can be compared."""
    kind = Kind.draw(seed)
    silent = replace(kind.sensor, noise_k=0.0, slow_noise_k=0.0, drift_k_s=0.0, step_k=1e-6)
    return replace(kind, sensor=silent)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(4))
def test_better_conductors_cool_the_plate_more(seed: int) -> None:
    kind = quiet(seed)
    assert fallen_k(kind, "aluminium", 2.0) > fallen_k(kind, "pvc", 2.0) > fallen_k(kind, "pu_foam", 2.0) > 0.0


def test_the_same_seed_gives_the_same_touch() -> None:
    first, again = (next(simulate_touches(Kind.draw(5), "pine", 3, (0,), seconds=1.0)) for _ in range(2))
    np.testing.assert_array_equal(first.fingers[0].trace.sensor_c, again.fingers[0].trace.sensor_c)
    assert first.object_c == again.object_c


def test_a_piece_is_the_same_in_any_part_of_the_touches() -> None:
    kind = Kind.draw(5)
    (_, second), (alone,) = (list(simulate_touches(kind, "pine", 3, some, seconds=1.0)) for some in ((0, 1), (1,)))
    np.testing.assert_array_equal(second.fingers[0].trace.sensor_c, alone.fingers[0].trace.sensor_c)


@pytest.mark.long
def test_fingers_share_the_object_and_differ_in_their_sensors() -> None:
    (hand,) = simulate_touches(quiet(6), "pvc", 1, (0,), preheats_k=(10.0,) * 5, seconds=1.0)
    assert len(hand.fingers) == 5
    assert len({round(float(finger.trace.sensor_c[-1]), 4) for finger in hand.fingers}) == 5


@pytest.mark.long
@pytest.mark.parametrize("name", ["copper", "pvc"])
def test_finer_steps_and_a_finer_grid_change_little(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    kind = quiet(7)
    usual = fallen_k(kind, name, 2.0)
    monkeypatch.setattr(touches, "STEP_S", touches.STEP_S / 2.0)
    assert fallen_k(kind, name, 2.0) == pytest.approx(usual, abs=0.01)
    monkeypatch.setattr(axisymmetric, "RINGS_INSIDE", 12)
    monkeypatch.setattr(axisymmetric, "RINGS_OUTSIDE", 12)
    monkeypatch.setattr(axisymmetric, "LAYERS", 24)
    assert fallen_k(kind, name, 2.0) == pytest.approx(usual, abs=0.05)


def test_kinds_differ() -> None:
    assert len({draw_sensor(seed).radius_m for seed in range(20)}) == 20
