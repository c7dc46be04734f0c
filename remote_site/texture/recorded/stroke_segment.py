"""What was found in one part of a recorded stroke."""

from dataclasses import dataclass, field

from common.wire.messages import ExplorationMode
from remote_site.texture.groove_period import Period


@dataclass(slots=True)
class Segment:
    """Part of a stroke in one mode on one surface.

    Attributes:
        mode: exploration mode.
        start_s: begin, s.
        end_s: end, s.
        roughness_v: roughness without grooves, V (or the signal's own unit); None if unknown.
        force_n: mean force, N; None where not recorded.
        speed_m_s: mean speed, m/s; None where unknown.
        impulses_s: times of grooves and edges, s.
        strengths_v: their curvatures for one newton, V.
        period: spatial period; None where there is none, or no speed is known.
        surface: name of the likeliest surface; None without a table or where it was not stroked.
        probability: of that surface, at the end.
        changed: whether it begins where the stroke came to another surface.
        fault: what is wrong with the sensor; None when nothing is.
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
    probability: float | None = None
    changed: bool = False
    fault: str | None = None
