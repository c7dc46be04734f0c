"""Off-line thermal identification of recorded touches: the same online classes, reading by reading."""

import logging
import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, TypedDict

import numpy as np

from common.files.each_once import require_each_once
from common.files.printable import printable
from common.runtime.parallel_map import Progress, in_order, unseen
from common.wire.messages import ThermalStatus
from remote_site.thermal.material_table import MaterialTable
from remote_site.thermal.thermal_identification import ThermalIdentification, ThermalKnowledge, knowledge_of
from remote_site.thermal.thermal_result import NO_CONTACT, ThermalResult
from remote_site.thermal.touch_estimate import TouchEvidence
from remote_site.thermal.touch_start import RecordedTouch, find_touch, reference_touch
from remote_site.traces.trace_files import ThermalTrace, TraceFile, UnreadFile, read_thermal, require_all

log = logging.getLogger(__name__)
DEFAULT_AT_S = (0.5, 1.0, 2.0, 3.0, 5.0, 7.0)
LEAST_HZ = 48.0
"""Sampling rate below which early answers are worse, Hz: 50 Hz with a clock that is 4 % slow."""

Line = dict[str, Any]


class Exponential(TypedDict):
    """Answer of the paper's exponential fit (Kron & Schmidt 2003, Eq. 11); None for an unknown value.

    Attributes:
        rate_per_s: rate of the response, 1/s.
        object_c: temperature that the response tends to, C.
        material: material with the nearest rate.
    """

    rate_per_s: float | None
    object_c: float | None
    material: str | None


class MaterialAnswer(TypedDict):
    """Answer about the object under the finger; None for an unknown value.

    Attributes:
        t_s: time since contact, s; no later sample is used.
        final: whether this is the answer from the whole trace.
        status: `no_contact`, `deciding`, `identified`, `ambiguous`, `unknown` or `unidentifiable`.
        material: name of the material if it is identified.
        best: likeliest calibrated material.
        probability: probability of `best`, 0..1.
        candidates: probability of each material that is still possible, 0..1.
        object_c: temperature of the object, C.
        object_c_sd: its standard deviation, K.
        effusivity: thermal effusivity, J/(m2 K s^0.5).
        effusivity_ln_sd: standard deviation of its logarithm.
        exponential: answer of the paper's method to the same samples.
        reason: why nothing is identified, as a code or, for an unusable file, a sentence.
    """

    t_s: float
    final: bool
    status: str
    material: str | None
    best: str | None
    probability: float
    candidates: dict[str, float]
    object_c: float | None
    object_c_sd: float | None
    effusivity: float | None
    effusivity_ln_sd: float | None
    exponential: Exponential
    reason: str | None


def identify_thermal(
    table: MaterialTable,
    traces: Sequence[Path] = (),
    at: Sequence[float] = DEFAULT_AT_S,
    touches: Path | None = None,
    processes: int = 1,
    progress: Progress = unseen,
) -> Iterator[Line]:
    """Yield one JSON line per requested time and a final one, for every trace and every joint touch.

    A trace that cannot be read is answered `unidentifiable` with the reason; all others are judged. A warning is logged
    for a joint touch without one of its traces, and for a trace that begins in contact or is slower than LEAST_HZ. A
    trace with `reference_c` is judged as two fingers on one object: the heated sensor and the unheated one.

    Args:
        table: calibrated materials.
        traces: files judged each by itself.
        at: times since contact, s; a line for t uses no sample later than that.
        touches: file `touch,trace` (paths relative to it): traces of several fingers on one object,
            judged jointly; each trace's clock starts at its own contact.
        processes: that share the work; the lines do not depend on it.
        progress: is given the share done, 0..1.

    Raises:
        ValueError: the file of touches cannot be used (names file, line and column), or a time is not positive. After
            all lines: a file is missing, or cannot be read.
    """
    _check_times(at)
    grouped = {} if touches is None else _read_touches(touches)
    # labelled as the caller named it, so that equal file names in two folders stay apart
    jobs = [({"trace": str(path)}, [path]) for path in traces]
    jobs += [({"touch": name}, paths) for name, paths in grouped.items()]
    unread: list[str] = []
    for lines, errors in in_order(partial(_answers, table.model_dump_json(), tuple(at)), jobs, processes, progress):
        yield from lines
        unread += errors
    require_all(unread, sum(len(paths) for _, paths in jobs))


def _answers(table: str, at: Sequence[float], job: tuple[Line, list[Path]]) -> tuple[list[Line], list[str]]:
    """Return the lines of one touch, and the errors of its files that are missing or cannot be read."""
    label, paths = job
    traces, broken, unread = [], "", list[str]()
    for path in paths:
        try:
            traces.append(read_thermal(path))
        except ValueError as error:
            broken = broken or str(error)
            if isinstance(error, UnreadFile):
                unread.append(str(error))
            if len(paths) > 1:
                log.warning("touch %s is judged without a trace: %s", printable(label["touch"]), printable(str(error)))
    for trace in traces:
        if trace.contact() == 0:
            log.warning(
                "%s: begins in contact, so that the start of the touch is not known and the answer may be wrong; "
                "record from 0.5 s before contact",
                printable(trace.name),
            )
        if (rate_hz := 1.0 / float(np.median(np.diff(trace.time_s)))) < LEAST_HZ:
            log.warning(
                "%s: %.3g samples/s, so that the time of contact is not exact and early answers may be wrong; "
                "record 100 samples/s, or use a table of touches at this rate",
                printable(trace.name),
                rate_hz,
            )
    return [{**label, **answer} for answer in _lines(traces, at, knowledge_of(table), broken)], unread


def identify_traces(
    table: MaterialTable, traces: Sequence[ThermalTrace], at: Sequence[float] = DEFAULT_AT_S
) -> list[MaterialAnswer]:
    """Return the answers to one touch of one or more fingers on one object: one for each time, and the final one.

    Args:
        table: calibrated materials.
        traces: a trace of each finger; each trace's clock starts at its own contact.
        at: times since contact, s.

    Raises:
        ValueError: there is no trace, or a time is not positive.
    """
    _check_times(at)
    if not traces:
        raise ValueError("nothing to identify: there is no trace")
    return list(_lines(traces, at, ThermalKnowledge.of(table)))


def _check_times(at: Sequence[float]) -> None:
    if any(not 0.0 < t < math.inf for t in at):
        raise ValueError(f"at_s: times must be positive and finite, not {', '.join(map(str, at))}")


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
    for name, traces in grouped.items():
        try:
            require_each_once(traces)
        except ValueError as error:
            raise ValueError(f"{path}: column trace: touch {name}: {error}") from None
    return grouped


class _Replay:
    """One sensor's touch, played into an identification up to any time since contact."""

    def __init__(self, knowledge: ThermalKnowledge, touch: RecordedTouch) -> None:
        self.knowledge = knowledge
        self.identification = ThermalIdentification(knowledge)
        self._readings = list(touch.readings())[1:]  # the reading at contact is where the touch starts
        self._next = 0
        self.identification.start(0.0, touch.start_c, touch.slope_k_s, touch.ambient_c)

    @property
    def times_s(self) -> list[float]:
        """Times of the readings since contact, s."""
        return [reading[0] for reading in self._readings]

    def play(self, until_s: float) -> ThermalResult:
        """Answer from all samples up to `until_s` after contact."""
        while self._next < len(self._readings) and self._readings[self._next][0] <= until_s + 1e-9:
            self.identification.step(*self._readings[self._next])
            self._next += 1
        return self.identification.answer


def _lines(
    traces: Sequence[ThermalTrace], at: Sequence[float], knowledge: ThermalKnowledge, broken: str = ""
) -> Iterator[MaterialAnswer]:
    """Yield the answers to one touch, the final one after the last sample; `broken` is what is wrong with a trace."""
    replays: list[_Replay] = []
    for trace in traces:
        touch = find_touch(trace)
        if touch is not None:
            replays.append(_Replay(knowledge, touch))
            if trace.reference_c is not None:
                replays.append(_Replay(knowledge.reference or knowledge, reference_touch(touch)))
    if not replays:
        answer = NO_CONTACT if not broken else ThermalResult(ThermalStatus.UNIDENTIFIABLE)
        for t_s in sorted(at):
            yield _answer(t_s, False, answer, broken)
        yield _answer(0.0, True, answer, broken)
        return
    judged = _Joint(knowledge, replays)
    for t_s in sorted(at):
        yield _answer(t_s, False, judged.play(t_s))
    yield _answer(judged.length_s, True, judged.play(math.inf))


class _Joint:
    """Sensors on one object, played side by side from their own contacts on."""

    def __init__(self, knowledge: ThermalKnowledge, replays: list[_Replay]) -> None:
        self._knowledge, self._replays = knowledge, replays
        self._times_s = sorted({round(t_s, 6) for replay in replays for t_s in replay.times_s})
        self._next = 0
        self._conclusion = knowledge.conclusion()
        self._answer: ThermalResult | None = None

    @property
    def length_s(self) -> float:
        """Time from contact to the last sample, s."""
        return self._times_s[-1] if self._times_s else 0.0

    def play(self, until_s: float) -> ThermalResult:
        """Answer from all samples up to `until_s` after each contact."""
        if len(self._replays) == 1:
            return self._replays[0].play(until_s)
        while self._next < len(self._times_s) and self._times_s[self._next] <= until_s + 1e-9:
            t_s = self._times_s[self._next]
            self._next += 1
            self._step(t_s)
        return self._answer or self._replays[0].play(until_s)

    def _evidence(self, replay: _Replay) -> TouchEvidence | None:
        found = replay.identification.evidence()
        if found is None or replay.knowledge is self._knowledge:
            return found
        return self._knowledge.posterior.beside(found)

    def _step(self, t_s: float) -> None:
        answers = [replay.play(t_s) for replay in self._replays]
        evidence = {replay: found for replay in self._replays if (found := self._evidence(replay)) is not None}
        if not evidence or not any(replay.identification.running for replay in self._replays):
            return
        posterior = self._knowledge.posterior.judge(list(evidence.values()))
        joint = self._conclusion.step(posterior, t_s, list(evidence))
        # Eq. 11 has no joint form: the finger nearest to the middle speaks for all
        rates = sorted((a for a in answers if a.rate_per_s is not None), key=lambda a: a.rate_per_s or 0.0)
        middle = rates[len(rates) // 2] if rates else joint
        self._answer = replace(
            joint,
            rate_per_s=middle.rate_per_s,
            exponential_object_c=middle.exponential_object_c,
            exponential_material=middle.exponential_material,
        )


def _rounded(value: float | None, digits: int) -> float | None:
    return None if value is None else round(value, digits)


def _answer(t_s: float, final: bool, answer: ThermalResult, broken: str = "") -> MaterialAnswer:
    return {
        "t_s": round(t_s, 3),
        "final": final,
        "status": answer.status.name.lower(),
        "material": answer.material,
        "best": answer.best,
        "probability": round(answer.probability, 4),
        "candidates": {name: round(p, 4) for name, p in answer.candidates.items()},
        "object_c": _rounded(answer.object_c, 2),
        "object_c_sd": _rounded(answer.object_c_sd, 2),
        "effusivity": _rounded(answer.effusivity, 1),
        "effusivity_ln_sd": _rounded(answer.effusivity_ln_sd, 3),
        "exponential": {
            "rate_per_s": _rounded(answer.rate_per_s, 4),
            "object_c": _rounded(answer.exponential_object_c, 2),
            "material": answer.exponential_material,
        },
        "reason": broken or answer.reason.code or None,
    }
