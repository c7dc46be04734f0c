"""Cost of identifying texture, beside a named unit timed by turns in the same run."""

from time import perf_counter

import numpy as np

from common.wire.messages import ExplorationMode
from remote_site.texture.texture_identification import BLOCK, TextureIdentification
from sim_sensors.traces.simulated_stroke import simulate_stroke
from tests.unit.remote_site.shipped_tables import SURFACES

MOST = 40.0
"""Units that 5 ms of one finger may cost: 16 were measured, at the fastest stroke there is."""


def test_a_block_of_samples_costs_no_more_than_forty_spectra_of_two_hundred() -> None:
    trace = simulate_stroke("closely_grooved_pvc", 90_000, 150.0, 1.0, length_m=0.2)
    moving = (trace.time_s > trace.stroke_s[0] + 0.1) & (trace.time_s < trace.stroke_s[1])
    signal, values = trace.pressure_v[moving], np.random.default_rng(0).standard_normal(200)
    identification = TextureIdentification(SURFACES)
    blocks_s, units_s = [], []
    for number in range(len(signal) // BLOCK):
        samples = signal[number * BLOCK : (number + 1) * BLOCK]
        begin_s = perf_counter()
        identification.step(0.005 * (number + 1), samples, 1.0, 0.15, ExplorationMode.STROKING)
        between_s = perf_counter()
        for _ in range(10):
            np.fft.rfft(values)
        units_s.append(0.1 * (perf_counter() - between_s))
        blocks_s.append(between_s - begin_s)
    assert float(np.median(blocks_s)) < MOST * float(np.median(units_s))
