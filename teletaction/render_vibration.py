"""A recorded stroke as the operator would feel it: the remote site's identification, then the operator's vibration."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from common.exploration import Exploration
from common.messages import Event, EventKind, ExplorationMode
from operator_site.render import StrokeSample, render_vibration
from operator_site.vibration import Surface
from remote_site.roughness import LEAK_HZ, RATE_HZ, Roughness
from remote_site.surface_class import (
    GROOVE_DECAY_PER_S,
    GROOVE_RAD_S,
    NOMINAL_FORCE_N,
    NOMINAL_SPEED_M_S,
    TAP_DECAY_PER_S,
    TAP_SPEED_PER_M_S,
    SurfaceTable,
    stroke_constants,
)
from remote_site.traces import read_stroke

CHUNK = 10
APPROACH_M_S = 0.05
"""A stroke's file does not say how fast the finger came down: an ordinary touch."""


def render_stroke(stroke: Path, table: SurfaceTable) -> Iterator[tuple[float, int, float]]:
    """Rows of time_s, mode, motor_rpm every 5 ms.

    A file without force counts as touching throughout, one without speed as stroked at the nominal speed.

    Raises:
        ValueError: the file cannot be used; names file, line and column.
    """
    return render_vibration(_samples(stroke, table))


def _samples(stroke: Path, table: SurfaceTable) -> Iterator[StrokeSample]:
    trace = read_stroke(stroke)
    time_s = np.arange(trace.time_s[0], trace.time_s[-1], 1.0 / RATE_HZ)
    signal = np.interp(time_s, trace.time_s, trace.signals[:, 0])
    none = np.full(len(time_s), np.nan)
    force = none if trace.force_n is None else np.interp(time_s, trace.time_s, trace.force_n)
    speed = none if trace.speed_m_s is None else np.interp(time_s, trace.time_s, trace.speed_m_s)
    exploration = Exploration()
    roughness = Roughness(0.0 if trace.force_n is None else LEAK_HZ)
    constants = stroke_constants(table, table.surfaces[0].ln_roughness)
    x_m, count = 0.0, 0
    for first in range(0, len(time_s) - CHUNK + 1, CHUNK):
        last = first + CHUNK - 1
        t_s = float(time_s[last])
        force_n = NOMINAL_FORCE_N if trace.force_n is None else float(force[last])
        speed_m_s = NOMINAL_SPEED_M_S if trace.speed_m_s is None else float(speed[last])
        x_m += speed_m_s * CHUNK / RATE_HZ
        mode = exploration.step(t_s, force_n, x_m, 0.0, 0.0)
        reading = roughness.step(t_s, signal[first : last + 1], mode, speed_m_s, force_n)
        happened = [(EventKind.TAP, APPROACH_M_S)] if exploration.began else []
        if reading.impulse:
            happened.append((EventKind.GROOVE, GROOVE_RAD_S))
        if reading.valid and mode is ExplorationMode.STROKING:
            constants = stroke_constants(table, table.ln_normal(reading.roughness_v, force_n, speed_m_s))
        events = [Event(count + n, kind, 0, round(t_s * 1e9), 0, value) for n, (kind, value) in enumerate(happened, 1)]
        count += len(events)
        yield StrokeSample(
            t_s,
            int(mode),
            speed_m_s,
            force_n,
            Surface(TAP_SPEED_PER_M_S, TAP_DECAY_PER_S, constants.k_stroke_v, constants.k_stroke_f, GROOVE_DECAY_PER_S),
            events,
        )
