"""What goes wrong on a network at a time: stalls, partitions, connections that are cut or half open."""

from typing import Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from common.streams import Direction

Way = Literal[Direction.TO_REMOTE, Direction.TO_OPERATOR]
WAYS: tuple[Way, Way] = (Direction.TO_REMOTE, Direction.TO_OPERATOR)
FaultKind = Literal["stall", "partition", "cut", "half_open"]
LONGEST_S = 3600.0


class Fault(BaseModel):
    """One fault.

    - `stall`: for `seconds` nothing arrives, then everything at once; nothing has to be sent again.
    - `partition`: for `seconds` nothing gets through, and TCP finds out by sending again and again; new connections
      wait for its end.
    - `cut`: every connection is reset, both ends see it at once; new ones may be made.
    - `half_open`: for `seconds` whatever is sent on the present connections vanishes without a word, new ones work;
      then the old ones are reset.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

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
        """The directions that it concerns."""
        return tuple(way for way in WAYS if self.direction in ("both", way.name.lower()))
