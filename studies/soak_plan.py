"""Which faults a soak does, in which order and which together: drawn at random, the same for the same seed."""

from collections.abc import Iterator
from dataclasses import dataclass
from random import Random

from studies.fault_table import DEVICE_FAULTS, NETWORK_FAULTS, PLATE_FAULTS, PROCESS_FAULTS, Fault, Outcome

FAULTS = (*NETWORK_FAULTS, *DEVICE_FAULTS, *PLATE_FAULTS, *PROCESS_FAULTS)
"""All of the table but the full disk, which a session has from its start or never."""
PAIR_SHARE = 0.25
"""So often a second fault comes while the first is in force."""
PAUSE_S = (2.0, 6.0)
"""Normal work after each turn."""
TO_PROCESS = ("kill", "stop", "slow")
_AT_ONCE = ("slow", "burn", "cut")
"""What is over when it has been done, so that nothing can be done meanwhile."""


@dataclass(frozen=True, slots=True)
class Turn:
    """One fault, or two of which the second lies within the first, and then `pause_s` of normal work."""

    first: Fault
    second: Fault | None
    pause_s: float

    @property
    def faults(self) -> tuple[Fault, ...]:
        """Both, or the one."""
        return (self.first,) if self.second is None else (self.first, self.second)

    @property
    def name(self) -> str:
        """What happens, in the table's words."""
        return " + ".join(fault.name for fault in self.faults)


def may_contain(first: Fault, second: Fault) -> bool:
    """Whether `second` can be done, from its beginning to its end, while `first` is in force."""
    if first.begin in _AT_ONCE or first.expected is Outcome.LATCHED:
        return False
    # A process that is dead, or was restarted, knows nothing of a fault that it was told before.
    of_process = first.begin in TO_PROCESS or second.begin in TO_PROCESS
    if of_process and first.where == second.where:
        return False
    return first is not second and (first.mend != second.mend or first.where != second.where or not first.mend)


def turns(seed: int) -> Iterator[Turn]:
    """Turns without end."""
    chance = Random(seed)
    for first in _dealt(chance):
        inner = [fault for fault in FAULTS if may_contain(first, fault)]
        second = chance.choice(inner) if inner and chance.random() < PAIR_SHARE else None
        yield Turn(first, second, chance.uniform(*PAUSE_S))


def _dealt(chance: Random) -> Iterator[Fault]:
    """Faults like cards: one of each suit a round, so that a short soak has all suits and a long one all faults."""
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
