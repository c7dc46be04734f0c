"""Runs the session of a soak: injects one turn of faults after the other, and makes the session work again."""

import signal
import time
from collections.abc import Callable
from pathlib import Path

from robustness.fault_session import FaultSession
from robustness.fault_table import Fault
from robustness.faulted_session import NotWorking
from robustness.faults import begin_and_end, recover
from robustness.soak_judge import WORKS_AGAIN_S, Episode
from robustness.soak_plan import Turn, turns
from robustness.soak_watch import watching
from teletaction.session.demo_files import PROCESSES

OVERLAP_S = 0.5
"""Delay of the second fault of a pair after the first, s."""
_LATCH_SHOWN_S = 0.5
"""Reaction time of a person to a latched fault, s."""
_LOOK_S = 5.0
_MOST_CLEARED = 4
Progress = Callable[[str], object]


class Soak:
    """One session and its faults.

    Attributes:
        log: file with the samples of its processes.
        episodes: its turns so far.
        ends_s: end times of each process's lives, s: the kills, and the end of the session.
        restarts: number of restarts of each process.
        begin_s, end_s: time at which the session first worked, and end of the last turn, s.
    """

    def __init__(self, folder: Path, progress: Progress):
        self.log = folder / "samples.jsonl"
        self.episodes: list[Episode] = []
        self.ends_s: dict[str, list[float]] = {process: [] for process in PROCESSES}
        self.restarts: dict[str, int] = {}
        self.begin_s = self.end_s = 0.0
        self._folder, self._tell = folder, progress

    def live(self, seconds: float, seed: int) -> None:
        """Start the session, run turns for `seconds`, and end the session."""
        with FaultSession.open(self._folder) as session, watching(self._folder, self.log):
            session.wait_until_working()
            self.begin_s = time.monotonic()
            for turn in turns(seed):
                time.sleep(turn.pause_s)
                # A fault that latches late belongs to the turn before the pause.
                if self.episodes and _latched(session) and not self._works_again(session, self.episodes[-1]):
                    break
                if time.monotonic() - self.begin_s > seconds or not self._live_through(session, turn):
                    break
            self.end_s = time.monotonic()
            self.restarts = dict(session.restarts)
            for ends_s in self.ends_s.values():
                ends_s.append(self.end_s)

    def _live_through(self, session: FaultSession, turn: Turn) -> bool:
        """Run one turn; return whether the session works after it."""
        episode = Episode(turn, time.monotonic())
        self._tell(f"{episode.begin_s - self.begin_s:6.1f} s  {turn.name}")
        if self.episodes:
            self.episodes[-1].next_s = episode.begin_s
        self.episodes.append(episode)
        try:
            self._do(session, turn)
        except (NotWorking, OSError) as problem:
            episode.wrong.append(str(problem))
        episode.end_s = time.monotonic()
        return self._works_again(session, episode)

    def _works_again(self, session: FaultSession, episode: Episode) -> bool:
        try:
            self._bring_back(session, episode)
        except NotWorking as problem:
            episode.wrong.append(str(problem))
            self._tell(f"          {problem}")
            return not session.processes.ended() and recover(session)
        self._tell(f"          works again after {episode.again_s:.1f} s {episode.latched or ''}")
        return True

    def _do(self, session: FaultSession, turn: Turn) -> None:
        first, second = turn.first, turn.second
        if second is None:
            self._note_kill(first, begin_and_end(session, first)[0])
            return
        begin_s = self._begin(session, first)
        time.sleep(OVERLAP_S)
        self._note_kill(second, begin_and_end(session, second)[0])
        time.sleep(max(0.0, begin_s + first.seconds - time.monotonic()))
        _end(session, first)

    def _begin(self, session: FaultSession, fault: Fault) -> float:
        match fault.begin:
            case "kill":
                begin_s = session.signal(fault.where, signal.SIGKILL)
            case "stop":
                begin_s = session.signal(fault.where, signal.SIGSTOP)
            case _:
                begin_s = session.command(fault.where, fault.begin)
        self._note_kill(fault, begin_s)
        return begin_s

    def _note_kill(self, fault: Fault, begin_s: float) -> None:
        if fault.begin == "kill":
            self.ends_s[fault.where].append(begin_s)

    def _bring_back(self, session: FaultSession, episode: Episode) -> None:
        """Wait until the session works, and clear latched faults as a person would.

        Raises:
            NotWorking: the session does not work in time, latches repeatedly, or a process has ended by itself.
        """
        deadline_s, cleared = time.monotonic() + WORKS_AGAIN_S, 0
        while True:
            if latched := _latched(session):
                episode.latched += [each for each in latched if each not in episode.latched]
                cleared += 1
                if cleared > _MOST_CLEARED:
                    raise NotWorking(f"latched repeatedly: {latched}")
                time.sleep(_LATCH_SHOWN_S)
                session.clear_and_engage()
                episode.cleared_s = time.monotonic()
                deadline_s = episode.cleared_s + WORKS_AGAIN_S
            for name in session.processes.ended():
                raise NotWorking(f"{name} has ended by itself: {session.processes.last_words(name)}")
            try:
                session.wait_until_working(_LOOK_S)
            except NotWorking:
                if time.monotonic() > deadline_s:
                    raise
            else:
                episode.works_s = time.monotonic()
                return


def _end(session: FaultSession, fault: Fault) -> None:
    match fault.begin:
        case "kill":
            session.restart(fault.where)
        case "stop":
            session.signal(fault.where, signal.SIGCONT)
        case _ if fault.mend:
            session.command(fault.where, fault.mend)


def _latched(session: FaultSession) -> list[tuple[str, str]]:
    return [(site, said.removeprefix("fault: ")) for site, said in session.states().items() if said.startswith("fault")]
