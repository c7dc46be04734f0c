"""Maps the hand's place to the commanded place of the remote hand, and heights of the remote site back to the hand.

Each axis is mapped alike: command = command_0 + (hand - hand_0) / scale. The open clutch holds the command. A change
of clutch or scale begins a new coupling at the present places, so that the command never steps. A command stays within
the range of a motion packet. The remote site's limits hold unchanged, in remote units.
"""

from typing import Annotated, NamedTuple, Self

from msgspec import Meta

from common.fingers import FINGERS
from common.limits import REMOTE_LOW_M, REMOTE_PLANE_M
from common.recording.recorded_row import Finite, FixedFive, Row
from common.wire.messages import MotionRow, columns

EDGE_PLANE_M = 0.020
"""Distance to the edge of the workspace along the bench at which the edge is shown, m."""
EDGE_HEIGHT_M = 0.001
"""Distance to the lowest height of a finger at which the edge is shown, and felt, m."""

_PLANE_M, _LOW_M, _HIGH_M = (
    columns(MotionRow)["x_m"].high,
    columns(MotionRow)["z_m"].low,
    columns(MotionRow)["z_m"].high,
)
"""Range of a command, m, as of the hand's own place: what a motion packet can hold."""

Scale = Annotated[int, Meta(ge=1, le=100)]


class Places(NamedTuple):
    """Place of a hand, and heights of its five fingertips, m."""

    x_m: float
    y_m: float
    z_m: tuple[float, ...]


AT_ORIGIN = Places(0.0, 0.0, (0.0,) * len(FINGERS))


class Coupling(Row):
    """A coupling of the hand to the remote hand. It never changes; a change of clutch or scale makes another."""

    open: bool
    """Whether the clutch is open: the command stays, and the hand is free."""
    scale: Scale
    """The hand's motion divided by the commanded motion."""
    hand_x_m: Finite
    hand_y_m: Finite
    hand_z_m: FixedFive[Finite]
    """Place of the hand at which the coupling began, m."""
    command_x_m: Finite
    command_y_m: Finite
    command_z_m: FixedFive[Finite]
    """Command at that place, m."""

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read what `pack` wrote; raises ValueError if the payload is something else."""
        row = super().unpack(payload)
        return DIRECT if row == DIRECT else row

    @property
    def direct(self) -> bool:
        """Whether the command is the hand's place itself, as in each new session."""
        return self is DIRECT

    def unlimited(self, hand: Places) -> Places:
        """Return the command for a hand at this place before its range is applied."""
        if self is DIRECT:
            return hand
        if self.open:
            return Places(self.command_x_m, self.command_y_m, self.command_z_m)
        n, (x_m, y_m, z_m) = self.scale, hand
        return Places(
            self.command_x_m + (x_m - self.hand_x_m) / n,
            self.command_y_m + (y_m - self.hand_y_m) / n,
            tuple(
                [
                    command_m + (height_m - hand_m) / n
                    for command_m, height_m, hand_m in zip(self.command_z_m, z_m, self.hand_z_m, strict=True)
                ]
            ),
        )

    def command(self, hand: Places) -> Places:
        """Return the command for a hand at this place."""
        place = self.unlimited(hand)
        return place if self is DIRECT else limited(place)

    def hand_height_m(self, finger: int, height_m: float) -> float:
        """Return the height of the hand's finger at which its command reaches a height of the remote site, m."""
        return self.hand_z_m[finger] + self.scale * (height_m - self.command_z_m[finger])


DIRECT = Coupling(False, 1, *AT_ORIGIN, *AT_ORIGIN)
"""The coupling of a new session: the command is the hand's place."""


def limited(place: Places) -> Places:
    """Return the nearest place that a motion packet can hold; the remote site applies its own limits."""
    x_m, y_m, z_m = place
    return Places(
        min(_PLANE_M, max(-_PLANE_M, x_m)),
        min(_PLANE_M, max(-_PLANE_M, y_m)),
        tuple([min(_HIGH_M, max(_LOW_M, height_m)) for height_m in z_m]),
    )


def edges(place: Places) -> list[str]:
    """Return the edges of the workspace that a command is close to: x-, x+, y-, y+, and low for a finger."""
    inner_m = REMOTE_PLANE_M - EDGE_PLANE_M
    close = {
        "x-": place.x_m < -inner_m,
        "x+": place.x_m > inner_m,
        "y-": place.y_m < -inner_m,
        "y+": place.y_m > inner_m,
        "low": min(place.z_m) < REMOTE_LOW_M + EDGE_HEIGHT_M,
    }
    return [edge for edge, is_close in close.items() if is_close]
