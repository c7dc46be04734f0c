"""Child processes at the two ends of a link, and the processor time that a process has used."""

import multiprocessing
import resource
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

from common.link.keys import Role, TrustedKeys, create_keys
from common.runtime.scheduling import become_timely
from common.wire.streams import STREAMS
from teletaction.session.demo_ports import HOST, free_port_block
from teletaction.session.processes import die_with_parent

ANSWER_S = 60.0
"""Silence after which an end is given up, s, beyond the time of its work."""
_SPAWN = multiprocessing.get_context("spawn")


class EndLost(RuntimeError):
    """A process of a measurement ended or fell silent."""


@dataclass(frozen=True, slots=True)
class Place:
    """Addresses and keys at which the ends of a measurement meet.

    Attributes:
        host, base_port: of the product's link; the ports behind it are for the bare sockets.
        remote_keys, operator_keys, observer_keys: key folders that trust each other.
    """

    host: str
    base_port: int
    remote_keys: Path
    operator_keys: Path
    observer_keys: Path

    def bare_port(self, number: int) -> int:
        """Port of a bare socket, 0 or 1."""
        return self.base_port + len(STREAMS) + number

    def bare_address(self, number: int) -> str:
        """ZeroMQ address of a bare socket, 0 or 1."""
        return f"tcp://{self.host}:{self.bare_port(number)}"

    @classmethod
    def prepare(cls, folder: Path) -> "Place":
        """Make keys for all ends in `folder`, and find free ports on this machine."""
        remote, operator, observer = (folder / name for name in ("remote", "operator", "observer"))
        public = create_keys(remote)
        TrustedKeys(remote).trust("operator", create_keys(operator))
        TrustedKeys(remote).trust("observer", create_keys(observer), Role.OBSERVER)
        for folder_of_client in (operator, observer):
            TrustedKeys(folder_of_client).trust("remote", public)
        return cls(HOST, free_port_block(len(STREAMS) + 2), remote, operator, observer)


@dataclass(frozen=True, slots=True)
class End:
    """A child process, and the connection to it."""

    name: str
    process: BaseProcess
    line: Connection

    def receive(self, seconds: float = 0.0) -> Any:
        """Next message of the process, within `seconds` and ANSWER_S; raises EndLost."""
        try:
            if self.line.poll(seconds + ANSWER_S):
                return self.line.recv()
        except EOFError:
            self.process.join(1.0)
            raise EndLost(f"{self.name}: ended with exit code {self.process.exitcode}") from None
        raise EndLost(f"{self.name}: silent for {seconds + ANSWER_S:g} s")


def _begin(work: Callable[..., None], line: Connection, *arguments: object) -> None:
    die_with_parent()
    become_timely()  # as a site does
    work(line, *arguments)


@contextmanager
def ends(*works: tuple[str, Callable[..., None], tuple[object, ...]]) -> Iterator[list[End]]:
    """Run `work(line, *arguments)` of each (name, work, arguments) in a process of its own; end them all afterwards."""
    running: list[End] = []
    try:
        for name, work, arguments in works:
            ours, theirs = _SPAWN.Pipe()
            process = _SPAWN.Process(target=_begin, args=(work, theirs, *arguments), name=name, daemon=True)
            process.start()
            theirs.close()
            running.append(End(name, process, ours))
        yield running
    finally:
        for end in running:
            end.line.close()
            end.process.join(2.0)
            if end.process.is_alive():
                end.process.kill()
                end.process.join()
            end.process.close()


def pipe() -> tuple[Connection, Connection]:
    """A connection between two child processes."""
    return _SPAWN.Pipe()


def cpu_s() -> float:
    """Processor time of all threads of this process so far, s."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime
