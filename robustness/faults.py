"""The fault matrix: injects every fault of the table into a session, and judges it at the simulated devices."""

import signal
import tempfile
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from functools import partial
from pathlib import Path
from typing import Any

import msgpack
import numpy as np

from common.faults.texts import said_fault
from common.fingers import FINGERS
from common.link.session_state import Happening
from common.recording.truncated_mcap import TruncatedMcap
from robustness.fault_judge import Done, Finding, Floats, Truth, judge
from robustness.fault_session import FaultSession
from robustness.fault_table import (
    DEVICE_FAULTS,
    DISK_FAULTS,
    NETWORK_FAULTS,
    PATIENT_FAULTS,
    PLATE_FAULTS,
    PROCESS_FAULTS,
    Fault,
    Outcome,
)
from robustness.faulted_session import FaultedSession, NotWorking
from robustness.virtual_fault_session import VirtualFaultSession
from teletaction.session.conclude import recordings_of

PATIENT = "patient"
"""Group of the faults whose session has a stop switch of the patient."""
GROUPS: dict[str, tuple[Fault, ...]] = {
    "network": NETWORK_FAULTS,
    "devices": DEVICE_FAULTS,
    "plate": PLATE_FAULTS,
    PATIENT: PATIENT_FAULTS,
    "processes": PROCESS_FAULTS,
    "disk": DISK_FAULTS,
}
_LATCH_SHOWN_S = 1.0
"""Time for which a latched session is left alone, s; nothing may come back by itself."""
_AFTERWARDS_S = 0.6
_STATUS_S = 1.5
"""Time within which every process has reported its status, s."""
Progress = Callable[[str], object]

REAL_ONLY = ("kill", "burn", "full", "cut", "half_open")
"""First words of faults that need real processes, a real disk or TCP, which the test bed lacks."""


def virtual(faults: Sequence[Fault]) -> tuple[Fault, ...]:
    """The faults that can be injected on the test bed as well."""
    return tuple(fault for fault in faults if fault.begin.split()[0] not in REAL_ONLY)


def run(
    groups: Sequence[str] = tuple(GROUPS), progress: Progress = lambda _: None, *, real: bool = False
) -> list[Finding]:
    """Inject every fault of some groups, and judge each.

    Args:
        groups: keys of GROUPS.
        progress: called with each fault's name when it begins, and with each problem.
        real: inject all into real processes; otherwise only those of REAL_ONLY, and the others on the test bed.
    """
    findings = []
    for group in groups:
        on_bed = () if real else virtual(GROUPS[group])
        findings += run_apart(on_bed, progress, opener(group, VirtualFaultSession))
        others = [fault for fault in GROUPS[group] if fault not in on_bed]
        findings += run_apart(others, progress, opener(group, FaultSession))
    return findings


def opener(
    group: str, kind: type[FaultSession] | type[VirtualFaultSession]
) -> Callable[[Path], AbstractContextManager[FaultedSession]]:
    """Return a function that opens a session for the faults of a group."""
    return partial(kind.open, patient_switch=group == PATIENT)


def run_apart(
    faults: Sequence[Fault],
    progress: Progress = lambda _: None,
    open_session: Callable[[Path], AbstractContextManager[FaultedSession]] = FaultSession.open,
) -> list[Finding]:
    """Inject some faults into a session of their own, which leaves no files; without faults there is no session."""
    if not faults:
        return []
    with tempfile.TemporaryDirectory(prefix="faults-") as folder:
        return run_group(faults, Path(folder), progress, open_session)


def run_group(
    faults: Sequence[Fault],
    out: Path,
    progress: Progress = lambda _: None,
    open_session: Callable[[Path], AbstractContextManager[FaultedSession]] = FaultSession.open,
) -> list[Finding]:
    """Inject some faults into one session that is recorded in `out`, and judge each."""
    done: list[Done] = []
    lost: dict[str, str] = {}
    with open_session(out) as session:
        session.wait_until_working()
        for fault in faults:
            progress(fault.name)
            begin_s = session.now_s()
            try:
                done.append(_do(session, fault))
            except NotWorking as problem:
                lost[fault.key] = str(problem)
                progress(f"  {problem}")
                done.append(Done(fault, begin_s, session.now_s(), session.now_s()))
                if not recover(session):
                    break
        session.wait(_AFTERWARDS_S)
    truth = read_truth(out)
    findings = [judge(each, truth) for each in done]
    for finding in findings:
        if finding.fault.key in lost:
            finding.wrong.append(lost[finding.fault.key])
    judged = {finding.fault for finding in findings}
    return findings + [Finding(fault, None, wrong=["not reached"]) for fault in faults if fault not in judged]


def _do(session: FaultedSession, fault: Fault) -> Done:
    begin_s, end_s = begin_and_end(session, fault)
    cleared_s = None
    if fault.expected is Outcome.LATCHED:
        session.wait(_LATCH_SHOWN_S)
        cleared_s = session.now_s()
        session.clear_and_engage()
    session.wait_until_working()
    return Done(fault, begin_s, end_s, session.now_s(), cleared_s)


def begin_and_end(session: FaultedSession, fault: Fault) -> tuple[float, float]:
    """Inject a fault; returns when it began, and when it was over."""
    if fault.begin == "stop":
        return session.stop(fault.where, fault.seconds)
    if fault.begin == "slow":
        return session.slow(fault.where, fault.seconds)
    if fault.begin in _REAL:
        assert isinstance(session, FaultSession)
        return _REAL[fault.begin](session, fault)
    if fault.network:
        session.command("network", fault.network)
    begin_s = session.command(fault.where, fault.begin)
    if fault.expected is Outcome.LATCHED:
        deadline_s = begin_s + fault.later_s + 1.0
        while session.now_s() < deadline_s and not any(s.startswith("fault") for s in session.states().values()):
            session.wait(0.02)
        session.wait(0.4)
    else:
        session.wait(fault.seconds)
    end_s = session.command(fault.where, fault.mend) if fault.mend else begin_s + fault.seconds
    if fault.network:
        session.command("network", "clear")
    return begin_s, end_s


def _kill(session: FaultSession, fault: Fault) -> tuple[float, float]:
    begin_s = session.signal(fault.where, signal.SIGKILL)
    session.wait(fault.seconds)
    return begin_s, session.restart(fault.where)


def _fill_disk(session: FaultSession, fault: Fault) -> tuple[float, float]:
    begin_s = session.fill_disk(full=True)
    session.wait(fault.seconds)
    end_s = session.fill_disk(full=False)
    session.wait(_STATUS_S)
    for site in ("remote", "operator"):
        if not session.figures(site).get("recording_failed"):
            raise NotWorking(f"{site} does not report that its recording stopped")
    return begin_s, end_s


_REAL: dict[str, Callable[[FaultSession, Fault], tuple[float, float]]] = {
    "kill": _kill,
    "burn": lambda session, fault: (session.now_s(), session.burn(fault.seconds)),
    "full": _fill_disk,
}
"""Faults that only real processes and their machine can have."""


def recover(session: FaultedSession) -> bool:
    """Bring a session back to work after a fault, so that the next one can be injected; returns whether it works."""
    try:
        session.mend()
        session.clear_and_engage()
        session.wait_until_working()
    except NotWorking:
        return False
    return True


def read_truth(out: Path) -> Truth:
    """Read the records of the simulations and of both sites; a kill may have truncated them."""
    streams: dict[str, list[tuple[float, Any]]] = {}
    for process in ("sim-remote", "sim-operator", "remote", "operator"):
        for path in recordings_of(out, process) if any(out.glob(f"{process}*.mcap")) else []:
            _collect(path, streams)
    for entries in streams.values():
        entries.sort(key=lambda entry: entry[0])
    fingers, patient = streams.get("truth_fingertips", []), streams.get("truth_contact", [])

    def five(entries: list[tuple[float, Any]], name: str) -> Floats:
        return np.array([entry[name] for _, entry in entries], dtype=np.float64).reshape(len(entries), len(FINGERS))

    sessions = streams.get("remote/session", []) + streams.get("operator/session", [])
    return Truth(
        finger_s=np.array([t for t, _ in fingers]),
        force_n=five(fingers, "force_n"),
        motor_mv=five(fingers, "motor_mv"),
        motor_rpm=five(fingers, "motor_rpm"),
        peltier=five(fingers, "peltier"),
        plate_c=five(fingers, "plate_c"),
        patient_s=np.array([t for t, _ in patient]),
        heater=five(patient, "heater"),
        sensor_plate_c=five(patient, "plate_c"),
        hand_x_m=np.array([entry["x_m"] for _, entry in patient]),
        hand_z_m=five(patient, "z_m"),
        contact_n=five(patient, "force_n"),
        faults=sorted((t, said_fault(happening.fault)) for t, happening in sessions if happening.what == "fault"),
        ticks_s={process: np.array([t for t, _ in streams.get(stream, [])]) for process, stream in _EACH_TICK.items()},
    )


_EACH_TICK = {
    "remote": "remote/sensed",
    "operator": "operator/input",
    "sim-remote": "truth_contact",
    "sim-operator": "truth_fingertips",
}
"""A stream of each process with an entry for each of its ticks."""
_ONLY_TIMES = ("remote/sensed", "operator/input")


def _collect(path: Path, streams: dict[str, list[tuple[float, Any]]]) -> None:
    wanted = {"remote/session", "operator/session", *_EACH_TICK.values()}
    with path.open("rb") as file:
        for topic, message in TruncatedMcap(file).messages():
            if topic in wanted:
                streams.setdefault(topic, []).append((message.log_time * 1e-9, _entry(topic, message.data)))


def _entry(topic: str, data: bytes) -> Any:
    if topic in _ONLY_TIMES:
        return None
    return Happening.unpack(data) if topic.endswith("/session") else msgpack.unpackb(data)
