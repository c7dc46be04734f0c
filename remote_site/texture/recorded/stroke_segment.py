"""Result of the identification for one part of a recorded stroke."""

from dataclasses import dataclass, field

from common.wire.messages import ExplorationMode
from remote_site.texture.groove_period import Period
from remote_site.texture.motion_spectrum import StrokeSpectrum


@dataclass(slots=True)
class Segment:
    """Part of a stroke in one mode on one surface.

    Attributes:
        mode: exploration mode.
        start_s: begin, s.
        end_s: end, s.
        roughness_v: roughness without grooves, V (or the signal's own unit); None if unknown.
        force_n: mean force, N; None if not recorded.
        speed_m_s: mean speed in either direction, m/s, of a slow recording only where it moves; None if unknown.
        impulses_s: times of grooves and edges, s.
        strengths_v: curvatures of these grooves and edges for one newton, V.
        period: spatial period; None without a period or a known speed.
        surface: name of the likeliest surface; None without a table or a stroke.
        spectrum: spectrum of the vibration; None without a stroke of 0.128 s or more.
        changed: whether the segment begins where the stroke reached another surface.
        fault: fault of the sensor; None without a fault.
    """

    mode: ExplorationMode
    start_s: float
    end_s: float
    roughness_v: float | None = None
    force_n: float | None = None
    speed_m_s: float | None = None
    impulses_s: list[float] = field(default_factory=list)
    strengths_v: list[float] = field(default_factory=list)
    period: Period | None = None
    surface: str | None = None
    spectrum: StrokeSpectrum | None = None
    changed: bool = False
    fault: str | None = None
