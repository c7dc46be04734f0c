"""A sender with a deadband, a link that loses packets, and a receiver that reckons between packets."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from common.link.deadband import REPEATS, Deadband, DeadReckoning, Places
from studies.deadband.courses import Course

Floats = NDArray[np.float64]
Ticks = NDArray[np.bool_]


class Hold:
    """Holds the last received value; the interface is that of `DeadReckoning`."""

    def __init__(self) -> None:
        self._last: Places | None = None

    def take(self, t_s: float, places: Places) -> None:
        """Take a packet."""
        self._last = places

    def at(self, t_s: float) -> Places | None:
        """The last received value, m."""
        return self._last


RECKONINGS: dict[str, Callable[[], Hold | DeadReckoning]] = {"hold": Hold, "linear": DeadReckoning}


def sent(course: Course, reckoning: str, step_m: NDArray[np.float64] | float, repeats: int = REPEATS) -> Ticks:
    """Ticks at which the sender sends, (ticks,); the sender does not know of losses.

    Args:
        course: motion of the hand.
        reckoning: the receiver's estimate, a name in RECKONINGS.
        step_m: the largest difference that is not sent, for all directions or for each.
        repeats: how often a change is repeated.
    """
    period_s = 1.0 / course.rate_hz
    deadband, receiver = Deadband(period_s, repeats), RECKONINGS[reckoning]()
    found = np.zeros(len(course.place_m), dtype=np.bool_)
    for tick, place_m in enumerate(course.place_m):
        t_s = tick * period_s
        believed = receiver.at(t_s)
        perceptible = believed is None or bool((np.abs(place_m - np.array(believed)) > step_m).any())
        if deadband.step(t_s, perceptible):
            receiver.take(t_s, place_m.tolist())
            found[tick] = True
    return found


def received_m(course: Course, reckoning: str, arrives: Ticks) -> Floats:
    """The receiver's estimate at each tick, shaped as the course, m; the link has no delay.

    Args:
        course: motion of the hand.
        reckoning: a name in RECKONINGS.
        arrives: the ticks whose packets arrive, (ticks,); the first must.
    """
    believed, period_s = RECKONINGS[reckoning](), 1.0 / course.rate_hz
    found = np.empty(course.place_m.shape)
    for tick, place_m in enumerate(course.place_m):
        if arrives[tick]:
            believed.take(tick * period_s, place_m.tolist())
        found[tick] = believed.at(tick * period_s)
    return found


def error_m(course: Course, reckoning: str, arrives: Ticks) -> Floats:
    """The largest error of any finger in any direction at each tick, (ticks,), m."""
    off = np.abs(received_m(course, reckoning, arrives) - course.place_m)
    return np.asarray(off.reshape(len(off), -1).max(axis=1))


def kept(sent_at: Ticks, loss: float, rng: np.random.Generator) -> Ticks:
    """Sent packets that arrive, (ticks,): each is lost by itself with the chance `loss`, but never the first."""
    arrives = sent_at & (rng.random(len(sent_at)) >= loss)
    arrives[0] = sent_at[0]
    return arrives
