"""Judges a soak: every fault must leave its trace, and all limits must hold. Pure: observations in, findings out."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from common.limits import CONTACT_FORCE_N, FINGER_FORCE_N, MOTOR_MAX_RPM, PLATE_PEAK_C, SENSOR_PLATE_C
from robustness.fault_judge import TICK_S
from robustness.fault_table import Fault, Outcome
from robustness.soak_plan import TO_PROCESS, Turn
from robustness.soak_watch import Sample

WORKS_AGAIN_S = 30.0
"""Longest time in which a session must work again after a fault ends or a person clears a latched fault, s."""
LIMITS = {
    ("truth_fingertips", "force_n"): ("force at the operator's finger, N", FINGER_FORCE_N),
    ("truth_fingertips", "motor_rpm"): ("motor, rpm", MOTOR_MAX_RPM),
    ("truth_fingertips", "plate_c"): ("operator's plate, C", PLATE_PEAK_C),
    ("truth_contact", "plate_c"): ("sensor's plate, C", SENSOR_PLATE_C),
    ("truth_contact", "force_n"): ("force on the patient, N", CONTACT_FORCE_N),
}
"""Name and upper limit of each simulated quantity, by its stream and field in the recording."""
_SITES = {"sim-remote": "remote", "sim-operator": "operator"}
_VALUES = ("open", "short", "frozen", "drift")
"""Words of a fault command that do not name a device."""
_ON_CAN = {"sim-remote": "telemanipulator", "sim-operator": "exoskeleton"}


@dataclass(slots=True)
class Episode:
    """Course of one turn; times on the monotonic clock, s.

    Attributes:
        begin_s, end_s: start of its first fault, and end of its last one.
        latched: each site that latched, with its reason, as its desk reported.
        cleared_s: time of the last clearing and engaging by a person; None if not needed.
        works_s: time at which the session worked again; None if it did not in time.
        next_s: start of the next turn.
        wrong: problems found.
    """

    turn: Turn
    begin_s: float
    end_s: float = 0.0
    latched: list[tuple[str, str]] = field(default_factory=list)
    cleared_s: float | None = None
    works_s: float | None = None
    next_s: float = float("inf")
    wrong: list[str] = field(default_factory=list)

    @property
    def again_s(self) -> float | None:
        """Time from the fault's end, or from its clearing, until the session worked again, s; None if it did not."""
        return None if self.works_s is None else self.works_s - (self.cleared_s or self.end_s)


def account(
    episode: Episode, samples: Mapping[str, Sequence[Sample]], recorded_faults: Iterable[tuple[float, str]]
) -> None:
    """Add to an episode's `wrong` each of its faults without a required trace, and each unexpected latch.

    A latch reported by the desk is a trace, because a person may clear it before the next sample, a second later.

    Args:
        episode: the episode to change.
        samples: samples of each process, in order of time.
        recorded_faults: time and reason of each latch in the sites' recordings.
    """
    begin_s, next_s = episode.begin_s, episode.next_s
    recorded = {text for time_s, text in recorded_faults if begin_s - TICK_S <= time_s < next_s}
    for site, reason in episode.latched:
        if reason not in recorded and not _dead(site, episode.turn.faults):
            episode.wrong.append(f"{site} latched ({reason}), but its recording does not show it")
    expected = any(fault.expected is Outcome.LATCHED for fault in episode.turn.faults)
    if episode.latched and not expected:
        episode.wrong.append(f"latched unexpectedly: {episode.latched[0][1]}")
    if not episode.latched and expected and episode.turn.second is None and not _frozen(episode.turn.first):
        episode.wrong.append("not latched")
    for fault in episode.turn.faults:
        others = [other for other in episode.turn.faults if other is not fault]
        latched = fault.expected is Outcome.LATCHED and any(_SITES.get(fault.where) == at for at, _ in episode.latched)
        if not latched and not _may_pass_unseen(fault, others) and not _traces(fault, samples, begin_s, next_s):
            episode.wrong.append(f"{fault.name}: left no trace")


def _dead(site: str, faults: Iterable[Fault]) -> bool:
    return any(fault.begin == "kill" and fault.where == site for fault in faults)


def _frozen(fault: Fault) -> bool:
    """Return whether a fault freezes a reading; it is detectable only after the drive moves, which may never happen."""
    return fault.begin.startswith("thermistor") and fault.begin.endswith("frozen")


def _may_pass_unseen(fault: Fault, others: Sequence[Fault]) -> bool:
    if fault.begin == "burn" or fault.begin.startswith("water") or _frozen(fault):
        return True  # a stroke cools too little to warm a dry hot side in this time
    site = _SITES.get(fault.where)
    hidden = any(other.begin in TO_PROCESS and other.where == site for other in others)
    # While another fault keeps outputs neutral, a drive that ignores commands may show no deviation.
    return hidden or (fault.expected is Outcome.LATCHED and bool(others))


def _traces(fault: Fault, samples: Mapping[str, Sequence[Sample]], begin_s: float, next_s: float) -> bool:
    where = _SITES.get(fault.where, fault.where) if fault.begin not in TO_PROCESS else fault.where
    seen = samples.get(where, ())
    before = [sample for sample in seen if sample.time_s < begin_s][-1:]
    during = [sample for sample in seen if begin_s <= sample.time_s < next_s]
    pid = before[0].pid if before else None
    status = before[0].status if before else {}
    word = fault.begin.split()[0]
    match fault.where, word:
        case _, "kill":
            return any(sample.pid != pid for sample in during)
        case _, "stop" | "slow":
            return any(sample.status["overruns"] > status.get("overruns", 0) for sample in during if sample.pid == pid)
        case "network", "delay":
            return any(sample.status["delay_ms"] > 0.0 for sample in during)
        case "network", kind:
            count = status.get("faults", {}).get(kind, 0)
            return any(sample.status["faults"].get(kind, 0) > count for sample in during)
    return any(_noticed(fault, sample.status, status if sample.pid == pid else {}) for sample in during)


def _noticed(fault: Fault, status: Mapping[str, Any], before: Mapping[str, Any]) -> bool:
    """Return whether a site's status newly reports a fault of one of its devices."""
    word, *target = fault.begin.split()
    if status["fault"]:
        return True
    named = [each for each in target if each not in _VALUES and not each.isdigit()]
    on_can = word in ("bus_off", "disobey", "intrude") or named[:1] == ["can"]
    device = _ON_CAN[fault.where] if on_can else " ".join(named)
    if status["missing"].startswith(device):
        return True
    if word == "piezo":
        return target[0] in status["texture_faults"]
    if any(limit.endswith("_unknown") for limit in status["limited"].get(target[0] if target else "", ())):
        return True
    counts = _counts(status, device)
    earlier = _counts(before, device)
    return any(count > earlier.get(name, 0) for name, count in counts.items())


def _counts(status: Mapping[str, Any], device: str) -> dict[str, int]:
    figures: Mapping[str, Any] = next(
        (each for name, each in status.get("devices", {}).items() if name.startswith(device)), {}
    )
    refused = sum(figures.get("refused", {}).values())
    return {"refused": refused, **{name: int(figures.get(name, 0)) for name in ("times_lost", "damaged", "missed")}}


Extreme = tuple[float, float]
"""Largest value of a quantity, and its time, s."""


def over_limits(extremes: Mapping[str, Extreme], episodes: Sequence[Episode]) -> list[str]:
    """Describe each exceeded limit, with the faults at that time, and each quantity without a recorded value."""
    wrong = []
    for name, limit in LIMITS.values():
        if name not in extremes:
            wrong.append(f"{name}: nothing was recorded")
            continue
        value, time_s = extremes[name]
        if not value <= limit:
            during = [each.turn.name for each in episodes if each.begin_s <= time_s < each.next_s]
            wrong.append(f"{name}: {value:.2f}, limit {limit:g}, during {during or 'normal work'}")
    return wrong
