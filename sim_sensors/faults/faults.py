"""Inject faults into the simulated devices with text commands.

FAULT TARGET [VALUE]      begins a fault, as in `thermistor index open`
mend FAULT TARGET         ends it; `plug DEVICE` is short for `mend unplug DEVICE`
mend                      ends all faults
"""

import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

log = logging.getLogger(__name__)

T = TypeVar("T")
End = Callable[[], object]


@dataclass(frozen=True, slots=True)
class Fault(Generic[T]):
    """One kind of fault.

    Attributes:
        usage: arguments of the command, as help text.
        targets: possible targets by name; an empty name stands for the only target.
        begin: breaks a target, given the text behind its name. It returns the function that mends the target,
            None if the fault ends by itself. It raises ValueError for an invalid text, before anything is broken.
    """

    usage: str
    targets: Mapping[str, T]
    begin: Callable[[T, str], End | None]

    def aim(self, words: str) -> tuple[str, str]:
        """Split a command's arguments into the target's name and the text behind it.

        Raises:
            ValueError: no target of that name.
        """
        for name in self.targets:
            if not name or words == name or words.startswith(f"{name} "):
                return name, words[len(name) :].strip()
        raise ValueError(f"unknown target {words!r}; known: {', '.join(self.targets)}")


class Faults:
    """Begin and end faults, and list those in force."""

    def __init__(self, kinds: Mapping[str, Fault[Any]]) -> None:
        self._kinds = kinds
        self._ends: dict[str, End] = {}

    @property
    def in_force(self) -> list[str]:
        """Name and target of each fault in force."""
        return list(self._ends)

    def apply(self, line: str) -> str:
        """Execute one command; return the faults in force after it, separated by commas.

        Raises:
            ValueError: the command is invalid; nothing has changed.
        """
        name, _, words = " ".join(line.split()).partition(" ")
        if name == "mend":
            self._mend(words)
        elif name == "plug":
            self._mend(f"unplug {words}")
        else:
            self._begin(name, words)
        log.info("%s", line)
        return ", ".join(self._ends)

    def _begin(self, name: str, words: str) -> None:
        kind = self._kinds.get(name)
        if kind is None:
            usages = [f"{each} {known.usage}".strip() for each, known in self._kinds.items()]
            raise ValueError(f"no fault {name!r}; use {', '.join(usages)}, plug DEVICE, or mend [FAULT TARGET]")
        try:
            target, text = kind.aim(words)
            end = kind.begin(kind.targets[target], text)
        except ValueError as error:
            raise ValueError(f"{name} {kind.usage}: {error}") from None
        if end is not None:
            self._ends[f"{name} {target}".strip()] = end

    def _mend(self, words: str) -> None:
        if words and words not in self._ends:
            raise ValueError(f"{words!r} is not in force; in force: {', '.join(self._ends) or 'nothing'}")
        for name in [words] if words else list(self._ends):
            self._ends[name]()
            del self._ends[name]
