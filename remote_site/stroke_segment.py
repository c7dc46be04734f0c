"""What was found in one part of a recorded stroke."""

from dataclasses import dataclass, field

from common.messages import ExplorationMode
from remote_site.groove_period import Period


@dataclass(slots=True)
class Segment:
    """Part of a stroke in one mode.

    Attributes:
        mode: exploration mode.
        start_s: begin, s.
        end_s: end, s.
        roughness_v: mean rectified signal without patterns, V (or the signal's own unit); None if unknown.
        force_n: mean force, N; None where not recorded.
        speed_m_s: mean speed, m/s; None where unknown.
        impulses_s: times of grooves and edges, s.
        period: spatial period; None where there is none, or no speed is known.
    """

    mode: ExplorationMode
    start_s: float
    end_s: float
    roughness_v: float | None = None
    force_n: float | None = None
    speed_m_s: float | None = None
    impulses_s: list[float] = field(default_factory=list)
    period: Period | None = None
