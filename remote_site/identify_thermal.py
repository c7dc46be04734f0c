"""Off-line thermal identification of recorded touches: the same online classes, sample by sample."""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from common.messages import ThermalStatus
from remote_site.material_evidence import MaterialEvidence
from remote_site.material_table import MaterialTable
from remote_site.thermal_identification import (
    NO_CONTACT,
    ThermalAnswer,
    ThermalIdentification,
    conclude,
)
from remote_site.thermal_touches import find_touch
from remote_site.traces import TraceFile, read_thermal

DEFAULT_AT_S = (0.5, 1.0, 2.0, 3.0, 5.0, 7.0)

Line = dict[str, Any]


def identify_thermal(
    table: MaterialTable,
    traces: Sequence[Path] = (),
    at: Sequence[float] = DEFAULT_AT_S,
    touches: Path | None = None,
) -> Iterator[Line]:
    """Yield one JSON line per requested time and a final one, for every trace and every joint touch.

    Args:
        table: calibrated materials.
        traces: files judged each by itself.
        at: times since contact, s; a line for t uses no sample later than that.
        touches: file `touch,trace` (paths relative to it): traces of several fingers on one object,
            judged jointly; each trace's clock starts at its own contact.

    Raises:
        ValueError: a file cannot be used (names file, line and column), or a time is not positive.
    """
    if any(not 0.0 < t < math.inf for t in at):
        raise ValueError(f"--at: times must be positive and finite, not {', '.join(map(str, at))}")
    evidence = MaterialEvidence(table)
    for path in traces:
        # labelled as the caller named it, so that equal file names in two folders stay apart
        yield from _lines({"trace": str(path)}, [_Replay(table, evidence, path)], at, evidence, table)
    if touches is not None:
        for name, paths in _read_touches(touches).items():
            replays = [_Replay(table, evidence, path) for path in paths]
            yield from _lines({"touch": name}, replays, at, evidence, table)


def _read_touches(path: Path) -> dict[str, list[Path]]:
    """Traces of each joint touch, in the order of the file."""
    file = TraceFile(path)
    grouped: dict[str, list[Path]] = {}
    for (line, name), (_, trace) in zip(file.texts("touch"), file.texts("trace"), strict=True):
        if not name or not trace:
            raise ValueError(f"{path}: line {line}: column {'trace' if name else 'touch'}: missing value")
        grouped.setdefault(name, []).append(path.parent / trace)
    if not grouped:
        raise ValueError(f"{path}: no touches are listed")
    return grouped


class _Replay:
    """One trace, played into an identification up to any time since contact."""

    def __init__(self, table: MaterialTable, evidence: MaterialEvidence, path: Path) -> None:
        self.identification = ThermalIdentification(table, evidence)
        touch = find_touch(read_thermal(path))
        self._readings = list(touch.readings()) if touch is not None else []
        self._next = 0
        if touch is not None:
            self.identification.start(0.0, touch.start_c, touch.ambient_c)

    @property
    def length_s(self) -> float:
        """Time from contact to the last sample, s."""
        return self._readings[-1][0] if self._readings else 0.0

    def play(self, until_s: float) -> ThermalAnswer:
        """Answer from all samples up to `until_s` after contact."""
        while self._next < len(self._readings) and self._readings[self._next][0] <= until_s + 1e-9:
            self.identification.step(*self._readings[self._next])
            self._next += 1
        return self.identification.answer


def _lines(
    label: Line, replays: list[_Replay], at: Sequence[float], evidence: MaterialEvidence, table: MaterialTable
) -> Iterator[Line]:
    """Lines of one trace or joint touch; the final one after the last sample."""
    for t_s in sorted(at):
        yield _line(label, t_s, False, _answer(replays, t_s, evidence, table))
    end_s = max(replay.length_s for replay in replays)
    yield _line(label, end_s, True, _answer(replays, math.inf, evidence, table))


def _answer(replays: list[_Replay], until_s: float, evidence: MaterialEvidence, table: MaterialTable) -> ThermalAnswer:
    """Answer of one finger, or of all together."""
    answers = [replay.play(until_s) for replay in replays]
    if len(replays) == 1:
        return answers[0]
    judged = [
        (answer, replay.identification.evidence)
        for answer, replay in zip(answers, replays, strict=True)
        if replay.identification.evidence is not None
    ]
    touching = [answer for answer in answers if answer.status is not ThermalStatus.NO_CONTACT]
    found = [weight for _, weight in judged if weight is not None]
    if not found:
        return touching[0] if touching else NO_CONTACT
    since_s = min(until_s, max(replay.length_s for replay in replays))
    joint = conclude(table.names(), evidence.judge(found), since_s)
    # Eq. 11 has no joint form: the finger nearest to the middle speaks for all
    rates = sorted((a for a, _ in judged if a.rate_per_s is not None), key=lambda a: a.rate_per_s or 0.0)
    middle = rates[len(rates) // 2] if rates else joint
    return ThermalAnswer(
        joint.status,
        joint.material,
        joint.best,
        joint.probability,
        joint.candidates,
        joint.object_c,
        joint.object_c_sd,
        middle.rate_per_s,
        middle.exponential_object_c,
        middle.exponential_material,
        joint.reason,
    )


def _rounded(value: float | None, digits: int) -> float | None:
    return None if value is None else round(value, digits)


def _line(label: Line, t_s: float, final: bool, answer: ThermalAnswer) -> Line:
    """An answer as the line that is printed."""
    return {
        **label,
        "t_s": round(t_s, 3),
        "final": final,
        "status": answer.status.name.lower(),
        "material": answer.material,
        "best": answer.best,
        "probability": round(answer.probability, 4),
        "candidates": {name: round(p, 4) for name, p in answer.candidates.items()},
        "object_c": _rounded(answer.object_c, 2),
        "object_c_sd": _rounded(answer.object_c_sd, 2),
        "exponential": {
            "rate_per_s": _rounded(answer.rate_per_s, 4),
            "object_c": _rounded(answer.exponential_object_c, 2),
            "material": answer.exponential_material,
        },
        "reason": answer.reason,
    }
