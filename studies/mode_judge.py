"""How well modes were told: time right, switches that were wrong, how late each was, and how fast the taps were."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from common.messages import ExplorationMode
from sim_sensors.simulated_exploration import Explored, Modes, Sensed
from sim_sensors.told_hand import TICK_S

MACHINE, PLAIN = "mode machine", "plain thresholds"
"""The methods that are judged."""
JUDGED = 3.0
"""The noise at which the modes must hold, times nominal."""
FREE, TAPPING, QUIESCENT, STROKING = ExplorationMode
SLACK_S = 0.050
"""A switch to a mode that is true within so long, before or after, is no wrong one."""
EARLY_S, LATE_S = 0.10, 0.50
"""A switch belongs to a true one that is at most so much later or earlier."""
LANDING_S = 0.05


class Machine(Protocol):
    """What tells modes."""

    @property
    def began(self) -> bool:
        """Whether the last step began a contact."""
        ...

    approach_m_s: float

    def step(self, t_s: float, force_n: float, x_m: float, y_m: float, z_m: float) -> ExplorationMode:
        """Take what is sensed at `t_s` and return the mode."""
        ...


@dataclass(frozen=True, slots=True)
class Told:
    """What a machine told of one scene.

    Attributes:
        mode: the mode that was told last, a value for each tick of the truth.
        taps: tick of the truth and approach speed, m/s, of each contact that was told.
        late: ticks of the truth at which the site's loop had been standing still.
    """

    mode: Modes
    taps: tuple[tuple[int, float], ...]
    late: NDArray[np.bool_]


def listen(make: Callable[[], Machine], explored: Explored, sensed: Sensed) -> Told:
    """Let a new machine go through what was sensed of a scene."""
    machine, modes, taps = make(), [], []
    columns = (sensed.time_s, sensed.force_n, sensed.x_m, sensed.y_m, sensed.z_m)
    for tick, row in zip(sensed.tick.tolist(), zip(*(column.tolist() for column in columns), strict=True), strict=True):
        modes.append(int(machine.step(*row)))
        if machine.began:
            taps.append((tick, machine.approach_m_s))
    ticks = np.arange(len(explored.mode))
    newest = np.searchsorted(sensed.tick, ticks, side="right") - 1
    late = np.isin(ticks, sensed.tick[1:][np.diff(sensed.tick) > 2])
    return Told(np.array(modes)[newest], tuple(taps), late)


def wrong_switches(true: Modes, told: Modes) -> list[bool]:
    """Of each switch that was told, in order, whether it was wrong."""
    slack = round(SLACK_S / TICK_S)
    return [told[at] not in true[max(0, at - slack) : at + slack + 1] for at in _switches(told)]


def longest_run(wrong: list[bool]) -> int:
    """Most wrong ones in a row."""
    longest = run = 0
    for each in wrong:
        run = run + 1 if each else 0
        longest = max(longest, run)
    return longest


def latencies(true: Modes, told: Told) -> Iterator[tuple[str, float | None, bool]]:
    """Of each true switch: its name, how much later it was told, s (None: never), and whether the loop stood still."""
    for at, following in pairwise([*_switches(true), len(true)]):
        mode = true[at]
        heard = _heard(told.mode, mode, at, min(following, at + round(LATE_S / TICK_S)))
        stood = False if heard is None else bool(told.late[heard])
        yield _name(true[at - 1], mode), None if heard is None else (heard - at) * TICK_S, stood


def tap_speeds(explored: Explored, told: Told) -> Iterator[tuple[float, float | None]]:
    """Of each landing: true approach speed and the one told, m/s; None where no contact was told."""
    for tick, true_m_s in explored.landings:
        near = [(abs(at - tick), speed) for at, speed in told.taps if abs(at - tick) * TICK_S <= LANDING_S]
        yield true_m_s, min(near)[1] if near else None


def _switches(mode: Modes) -> list[int]:
    switches: list[int] = (np.flatnonzero(np.diff(mode)) + 1).tolist()
    return switches


def _heard(told: Modes, mode: int, at: int, until: int) -> int | None:
    """When `mode` was told first around a true switch to it."""
    if told[at] != mode:
        later = np.flatnonzero(told[at:until] == mode)
        return at + int(later[0]) if len(later) else None
    first = at
    while first > max(0, at - round(EARLY_S / TICK_S)) and told[first - 1] == mode:
        first -= 1
    return first


def _name(before: int, mode: int) -> str:
    if mode == FREE:
        return "release"
    if mode == TAPPING:
        return "contact"
    if before == TAPPING:
        return "end of the tap"
    return "stroke begins" if mode == STROKING else "stroke ends"
