"""Define network faults: stalls, partitions, and connections that are cut or half open."""

from typing import Literal, Self

from pydantic import Field, model_validator

from common.files.strict_model import StrictModel
from common.wire.streams import Direction

Way = Literal[Direction.TO_REMOTE, Direction.TO_OPERATOR]
WAYS: tuple[Way, Way] = (Direction.TO_REMOTE, Direction.TO_OPERATOR)
FaultKind = Literal["stall", "partition", "cut", "half_open"]
LONGEST_S = 3600.0


class Fault(StrictModel):
    """One fault of a network.

    - `stall`: nothing arrives for `seconds`, then everything arrives at once; no segment is retransmitted.
    - `partition`: nothing gets through for `seconds`, and TCP keeps retransmitting; new connections wait for the end.
    - `cut`: every connection is reset, which both ends see at once; new connections are possible.
    - `half_open`: bytes sent on the present connections are lost silently for `seconds`, then these connections are
      reset; new connections work throughout.
    """

    at_s: float = Field(ge=0.0)
    kind: FaultKind
    seconds: float | None = Field(default=None, gt=0.0, le=LONGEST_S)
    direction: Literal["both", "to_remote", "to_operator"] = "both"

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.kind == "cut":
            if self.seconds is not None or self.direction != "both":
                raise ValueError("a cut ends both directions at once: give neither seconds nor direction")
        elif self.seconds is None:
            raise ValueError(f"a {self.kind} needs its length in seconds")
        return self

    @property
    def ways(self) -> tuple[Way, ...]:
        """Directions that the fault affects."""
        return tuple(way for way in WAYS if self.direction in ("both", way.name.lower()))
