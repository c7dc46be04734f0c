import numpy as np

from sim_sensors.physics.ssr_converter import celsius_of, counts_of


def test_ends_of_the_scale():
    assert counts_of(np.array([-5.0, 0.0, 60.0, 80.0])).tolist() == [0, 0, 4095, 4095]


def test_reading_returns_the_temperature_within_half_a_step():
    true_c = np.linspace(1.0, 59.0, 5000)
    assert np.abs(celsius_of(counts_of(true_c)) - true_c).max() < 0.009
