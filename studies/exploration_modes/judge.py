"""Judges reported exploration modes: wrong switches, latency of each switch, and approach speed of the taps."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from common.wire.messages import ExplorationMode
from sim_sensors.traces.commanded_hand import TICK_S
from sim_sensors.traces.simulated_exploration import Explored, Modes, NoisySample

MACHINE, PLAIN = "mode machine", "plain thresholds"
"""The methods that are judged."""
JUDGED = 3.0
"""Noise at which the modes must hold, as a multiple of nominal."""
FREE, TAPPING, QUIESCENT, STROKING = ExplorationMode
SLACK_S = 0.050
"""Tolerance of a switch, s: it is right where its mode is true within this time before or after it."""
EARLY_S, LATE_S = 0.10, 0.50
"""Largest lead and largest lag of a reported switch on the true switch that it belongs to, s."""
LANDING_S = 0.05


class Machine(Protocol):
    """A detector of exploration modes."""

    @property
    def began(self) -> bool:
        """Whether the last step began a contact."""
        ...

    approach_m_s: float

    def step(self, t_s: float, force_n: float, x_m: float, y_m: float, z_m: float) -> ExplorationMode:
        """Take the readings at `t_s`, and return the mode."""
        ...


@dataclass(frozen=True, slots=True)
class Reported:
    """Modes and taps that a machine reported of one scene.

    Attributes:
        mode: the newest reported mode at each tick of the truth.
        taps: tick of the truth and approach speed, m/s, of each reported contact.
        late: whether the site's loop had stood still, for each tick of the truth.
    """

    mode: Modes
    taps: tuple[tuple[int, float], ...]
    late: NDArray[np.bool_]


def listen(make: Callable[[], Machine], explored: Explored, sensed: NoisySample) -> Reported:
    """Run a new machine over the readings of a scene."""
    machine, modes, taps = make(), [], []
    columns = (sensed.time_s, sensed.force_n, sensed.x_m, sensed.y_m, sensed.z_m)
    for tick, row in zip(sensed.tick.tolist(), zip(*(column.tolist() for column in columns), strict=True), strict=True):
        modes.append(int(machine.step(*row)))
        if machine.began:
            taps.append((tick, machine.approach_m_s))
    ticks = np.arange(len(explored.mode))
    newest = np.searchsorted(sensed.tick, ticks, side="right") - 1
    late = np.isin(ticks, sensed.tick[1:][np.diff(sensed.tick) > 2])
    return Reported(np.array(modes)[newest], tuple(taps), late)


def wrong_switches(true: Modes, reported: Modes) -> list[bool]:
    """Whether each reported switch was wrong, in order."""
    slack = round(SLACK_S / TICK_S)
    return [reported[at] not in true[max(0, at - slack) : at + slack + 1] for at in _switches(reported)]


def longest_run(wrong: list[bool]) -> int:
    """Largest number of wrong switches in a row."""
    longest = run = 0
    for each in wrong:
        run = run + 1 if each else 0
        longest = max(longest, run)
    return longest


def latencies(true: Modes, reported: Reported) -> Iterator[tuple[str, float | None, bool]]:
    """Name and latency, s, of each true switch (None: never reported), and whether the loop had stood still."""
    for at, following in pairwise([*_switches(true), len(true)]):
        mode = true[at]
        heard = _heard(reported.mode, mode, at, min(following, at + round(LATE_S / TICK_S)))
        stood = False if heard is None else bool(reported.late[heard])
        yield _name(true[at - 1], mode), None if heard is None else (heard - at) * TICK_S, stood


def tap_speeds(explored: Explored, reported: Reported) -> Iterator[tuple[float, float | None]]:
    """True and reported approach speed of each landing, m/s; None where no contact was reported."""
    for tick, true_m_s in explored.landings:
        near = [(abs(at - tick), speed) for at, speed in reported.taps if abs(at - tick) * TICK_S <= LANDING_S]
        yield true_m_s, min(near)[1] if near else None


def _switches(mode: Modes) -> list[int]:
    switches: list[int] = (np.flatnonzero(np.diff(mode)) + 1).tolist()
    return switches


def _heard(reported: Modes, mode: int, at: int, until: int) -> int | None:
    """Tick at which `mode` was first reported around a true switch to it."""
    if reported[at] != mode:
        later = np.flatnonzero(reported[at:until] == mode)
        return at + int(later[0]) if len(later) else None
    first = at
    while first > max(0, at - round(EARLY_S / TICK_S)) and reported[first - 1] == mode:
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
