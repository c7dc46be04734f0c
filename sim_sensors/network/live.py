"""Run a network: follow its timetable, and apply commands that change it while it runs."""

from dataclasses import dataclass, field

from pydantic import ValidationError

from sim_sensors.network.conditions import Conditions
from sim_sensors.network.fault import WAYS, Fault, Way
from sim_sensors.network.file import MOST_MS, Network
from sim_sensors.network.path import NetworkPath


@dataclass(slots=True)
class LiveNetwork:
    """One network on a running clock. Time is an argument, s, and never runs backwards.

    Attributes:
        network: its conditions and faults, by network time from 0.
        start_s: clock time of network time 0; None before the start, with the conditions of time 0 and no faults.
        paths: both directions.
        happened: the faults so far, and the clock time at which each began.
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
        """Return the network time, s."""
        return 0.0 if self.start_s is None else max(0.0, now_s - self.start_s)

    def conditions(self, now_s: float) -> Conditions:
        """Return the present conditions."""
        return self.network.conditions(self.time_s(now_s)) if self._set is None else self._set

    def partitioned(self, now_s: float) -> bool:
        """Return whether new connections are impossible."""
        return any(path.partitions.end_s(now_s) is not None for path in self.paths.values())

    def begin_faults(self, now_s: float) -> list[tuple[float, Fault]]:
        """Begin the due faults and return each with its start, s; the caller applies them to the connections."""
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
        """Execute a command and return a description of its effect.

        - `partition 10`, `stall 3`, `half_open 5` (seconds, then `to_remote` or `to_operator` for one direction), `cut`
        - `delay 400 20`: sets the one-way delay and its jitter, ms, in place of the timetable's; default jitter 0
        - `clear`: ends stalls and partitions, and returns to the timetable's delay
        - `start`: starts the timetable at time 0

        Raises:
            ValueError: the command is invalid.
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
