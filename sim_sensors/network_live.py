"""A network in use: its timetable set going, and what is changed from outside while it runs."""

from dataclasses import dataclass, field

from pydantic import ValidationError

from sim_sensors.network_conditions import Conditions
from sim_sensors.network_fault import WAYS, Fault, Way
from sim_sensors.network_file import MOST_MS, Network
from sim_sensors.network_path import NetworkPath


@dataclass(slots=True)
class LiveNetwork:
    """One network on a running clock. Time is an argument, s, and never runs backwards.

    Attributes:
        network: what it is like, and its faults, by its own time from 0.
        start_s: when its time 0 was; None while it waits to be started: then it stays as at time 0, without faults.
        paths: both directions.
        happened: the faults so far, and when each began by the clock.
    """

    network: Network
    start_s: float | None = None
    paths: dict[Way, NetworkPath] = field(init=False)
    happened: list[tuple[float, Fault]] = field(default_factory=list)
    _next: int = 0
    _set: Conditions | None = None
    _asked: list[Fault] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.paths = {way: NetworkPath(self.conditions) for way in WAYS}

    def time_s(self, now_s: float) -> float:
        """The network's own time."""
        return 0.0 if self.start_s is None else max(0.0, now_s - self.start_s)

    def conditions(self, now_s: float) -> Conditions:
        """What it is like now."""
        return self.network.conditions.at(self.time_s(now_s)) if self._set is None else self._set

    def partitioned(self, now_s: float) -> bool:
        """Whether no new connection can be made."""
        return any(path.partitions.end_s(now_s) is not None for path in self.paths.values())

    def begin_faults(self, now_s: float) -> list[tuple[float, Fault]]:
        """Begin the faults that are due, and return them with their beginnings; connections are the caller's part."""
        begun = [(now_s, fault) for fault in self._asked]
        self._asked.clear()
        timetable = self.network.faults
        while self.start_s is not None and self._next < len(timetable):
            fault = timetable[self._next]
            if fault.at_s > self.time_s(now_s):
                break
            begun.append((self.start_s + fault.at_s, fault))
            self._next += 1
        for begin_s, fault in begun:
            for path in (self.paths[way] for way in fault.ways):
                if fault.kind == "stall":
                    path.stalls.add(begin_s, fault.seconds or 0.0)
                elif fault.kind == "partition":
                    path.partitions.add(begin_s, fault.seconds or 0.0)
        self.happened += begun
        return begun

    def obey(self, command: str, now_s: float) -> str:
        """Carry out a command and say what it did.

        - `partition 10`, `stall 3`, `half_open 5` (seconds, then `to_remote` or `to_operator` for one direction), `cut`
        - `delay 400 20`: one way and its jitter, ms, instead of the timetable's; without jitter 0
        - `clear`: ends stalls and partitions, and goes back to the timetable's delay
        - `start`: time 0 of the timetable

        Raises:
            ValueError: it is no such command.
        """
        match command.split():
            case ["start"]:
                if self.start_s is not None:
                    raise ValueError("start: the timetable is running already")
                self.start_s = now_s
                return "started"
            case ["clear"]:
                self._set = None
                for path in self.paths.values():
                    path.stalls.end_all(now_s)
                    path.partitions.end_all(now_s)
                return "as in the timetable"
            case ["delay", delay_ms, *rest] if len(rest) <= 1:
                self._set_delay(now_s, *(_number("delay", word) for word in (delay_ms, *rest)))
                return f"{delay_ms} ms one way"
            case ["partition" | "stall" | "half_open" | "cut" as kind, *rest] if len(rest) <= 2:
                self._asked.append(_fault(kind, rest))
                return " ".join([kind, *rest])
            case _:
                raise ValueError(f"{command!r}: expected partition, stall, half_open, cut, delay, clear or start")

    def _set_delay(self, now_s: float, delay_ms: float, jitter_ms: float = 0.0) -> None:
        if not 0.0 <= jitter_ms <= delay_ms <= MOST_MS:
            raise ValueError(f"delay: from 0 to {MOST_MS:g} ms, with a jitter of at most the delay")
        present = self.conditions(now_s)
        self._set = Conditions(1e-3 * delay_ms, 1e-3 * jitter_ms, present.loss, present.rate_bit_s)


def _fault(kind: str, words: list[str]) -> Fault:
    fields: dict[str, object] = {"at_s": 0.0, "kind": kind}
    if words:
        fields["seconds"] = _number(kind, words[0])
    if words[1:]:
        fields["direction"] = words[1]
    try:
        return Fault.model_validate(fields)
    except ValidationError as error:
        first = error.errors()[0]
        field_name = "".join(f"{part}: " for part in first["loc"])
        raise ValueError(f"{kind}: {field_name}{first['msg'].removeprefix('Value error, ')}") from None


def _number(command: str, word: str) -> float:
    try:
        return float(word)
    except ValueError:
        raise ValueError(f"{command}: {word!r} is no number") from None
