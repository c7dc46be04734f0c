from itertools import islice

import numpy as np

from sim_sensors.physics.remote_world import normal_rows


def test_rows_are_those_that_single_draws_give() -> None:
    rows, one_by_one = normal_rows(np.random.default_rng(3), 5), np.random.default_rng(3)
    for row in islice(rows, 1000):
        assert row == one_by_one.standard_normal(5).tolist()
