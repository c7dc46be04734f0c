"""Renders a recorded stroke as vibration: the remote site's identification, then the operator site's vibration."""

from collections.abc import Iterator

from common.wire.messages import Event, EventKind, ExplorationMode
from operator_site.offline_rendering import StrokeSample, render_vibration
from operator_site.vibration.vibration import Surface
from remote_site.texture.recorded.stroke_playback import even_stroke, felt
from remote_site.texture.surface_table import (
    GROOVE_DECAY_PER_S,
    TAP_DECAY_PER_S,
    TAP_SPEED_PER_M_S,
    StrokeLaw,
    SurfaceTable,
)
from remote_site.texture.texture_identification import groove_rad_s
from remote_site.texture.texture_law import ln_roughness
from remote_site.traces.trace_files import StrokeTrace

APPROACH_M_S = 0.05
"""Assumed approach speed of the finger, m/s: that of an ordinary touch. A stroke's file does not hold it."""


def render_stroke(stroke: StrokeTrace, table: SurfaceTable) -> Iterator[tuple[float, int, float]]:
    """Yield rows of time_s, mode and motor_rpm every 5 ms.

    A stroke without force counts as in contact throughout, one without speed as a stroke at nominal speed.
    """
    return render_vibration(_samples(stroke, table))


def _samples(stroke: StrokeTrace, table: SurfaceTable) -> Iterator[StrokeSample]:
    law = StrokeLaw(table)
    constants = law.at(table.surfaces[0].ln_roughness)
    count = 0
    for block in felt(even_stroke(stroke), table):
        texture = block.texture
        happened = [(EventKind.TAP, APPROACH_M_S)] if block.began else []
        happened += [
            (EventKind.GROOVE, groove_rad_s(impulse.strength_v, table.groove_v)) for impulse in texture.impulses
        ]
        if texture.valid and block.mode is ExplorationMode.STROKING:
            constants = law.at(ln_roughness(texture.roughness_v))
        time_ns = round(block.end_s * 1e9)
        events = [Event(count + n, kind, 0, time_ns, 0, value) for n, (kind, value) in enumerate(happened, 1)]
        count += len(events)
        yield StrokeSample(
            block.end_s,
            int(block.mode),
            block.speed_m_s,
            block.force_n,
            Surface(TAP_SPEED_PER_M_S, TAP_DECAY_PER_S, constants.k_stroke_v, constants.k_stroke_f, GROOVE_DECAY_PER_S),
            events,
        )
