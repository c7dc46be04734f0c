"""Draws the faults of a soak at random, with their order and their pairs; the same seed gives the same draw."""

from collections.abc import Iterator
from dataclasses import dataclass
from random import Random

from robustness.fault_table import DEVICE_FAULTS, NETWORK_FAULTS, PLATE_FAULTS, PROCESS_FAULTS, Fault, Outcome

FAULTS = (*NETWORK_FAULTS, *DEVICE_FAULTS, *PLATE_FAULTS, *PROCESS_FAULTS)
"""All faults of the table except the full disk, which must exist from the start of a session."""
PAIR_SHARE = 0.25
"""Share of turns with a second fault while the first is active, 0..1, where a second one is possible."""
PAUSE_S = (2.0, 6.0)
"""Range of the time of normal work after each turn, s."""
TO_PROCESS = ("kill", "stop", "slow")
_AT_ONCE = ("slow", "burn", "cut")
"""Commands of faults that end at once, so that no second fault fits into them."""


@dataclass(frozen=True, slots=True)
class Turn:
    """One fault, or two of which the second lies within the first, followed by `pause_s` of normal work."""

    first: Fault
    second: Fault | None
    pause_s: float

    @property
    def faults(self) -> tuple[Fault, ...]:
        """One or both faults, in order of their starts."""
        return (self.first,) if self.second is None else (self.first, self.second)

    @property
    def name(self) -> str:
        """Names of the faults in the table."""
        return " + ".join(fault.name for fault in self.faults)


def may_contain(first: Fault, second: Fault) -> bool:
    """Return whether `second` can begin and end while `first` is active."""
    if first.begin in _AT_ONCE or first.expected is Outcome.LATCHED:
        return False
    # A dead or restarted process has lost the fault that was commanded before.
    of_process = first.begin in TO_PROCESS or second.begin in TO_PROCESS
    if of_process and first.where == second.where:
        return False
    return first is not second and (first.mend != second.mend or first.where != second.where or not first.mend)


def turns(seed: int) -> Iterator[Turn]:
    """Yield an endless sequence of turns."""
    chance = Random(seed)
    for first in _dealt(chance):
        inner = [fault for fault in FAULTS if may_contain(first, fault)]
        second = chance.choice(inner) if inner and chance.random() < PAIR_SHARE else None
        yield Turn(first, second, chance.uniform(*PAUSE_S))


def _dealt(chance: Random) -> Iterator[Fault]:
    """Yield one fault of each kind per round, so that a short soak has all kinds and a long one all faults."""
    suits: dict[str, list[Fault]] = {}
    for fault in FAULTS:
        suits.setdefault(_suit(fault), []).append(fault)
    cards: dict[str, list[Fault]] = {suit: [] for suit in suits}
    while True:
        for suit in chance.sample(list(suits), len(suits)):
            cards[suit] = cards[suit] or chance.sample(suits[suit], len(suits[suit]))
            yield cards[suit].pop()


def _suit(fault: Fault) -> str:
    if fault.where == "network":
        return "network"
    if fault.begin == "kill":
        return "dead process"
    if fault.begin in ("stop", "slow", "burn"):
        return "late process"
    return "latching device" if fault.expected is Outcome.LATCHED else "device"
