"""Two network namespaces joined by a cable whose packets can be delayed and lost.

A namespace has no name and no file: it lives as long as a process that reads its input from this one, and so do the
programs inside. However this process ends, nothing stays behind.
"""

import os
import shutil
import subprocess
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

REMOTE, OPERATOR = "192.0.2.1", "192.0.2.2"
"""Addresses of the two hosts, from a range that is nobody's."""
_CABLE = "cable"
_IMPAIRMENT = Path(__file__).with_name("impairment.py")


def why_not() -> str:
    """Why this machine cannot do it, and what helps; empty when it can."""
    if os.geteuid() != 0:
        return "only root can make network namespaces"
    for program in ("unshare", "nsenter", "ip", "iptables"):
        if shutil.which(program) is None:
            return f'{program} is not installed: `eval "$(tests/network/prepare.sh)"` first'
    python = os.environ.get("IMPAIRMENT_PYTHON", "")
    if not python:
        return 'IMPAIRMENT_PYTHON is not set: `eval "$(tests/network/prepare.sh)"` first'
    probe = "ip link set lo up && iptables -A INPUT -j NFQUEUE --queue-num 1"
    found = subprocess.run(("unshare", "--net", "sh", "-c", probe), capture_output=True, text=True, check=False)
    return f"this kernel gives no namespace or no packet queue: {found.stderr.strip()}" if found.returncode else ""


def namespace_of(process: str) -> str:
    """The kernel's name of the network namespace that a process lives in; raises OSError when it is gone."""
    return os.readlink(f"/proc/{process}/ns/net")


class Program:
    """A program that answers in lines and ends with its input."""

    def __init__(self, *command: str) -> None:
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    @property
    def pid(self) -> int:
        """Its process."""
        return self._process.pid

    def say(self, line: str) -> None:
        """Write a line to it."""
        assert self._process.stdin is not None
        self._process.stdin.write(line + "\n")
        self._process.stdin.flush()

    def hear(self) -> str:
        """The next line from it, waited for; raises RuntimeError when it has ended instead."""
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            raise RuntimeError(f"{self._process.args!r} ended with exit code {self._process.wait(10)}")
        return line.rstrip("\n")

    def end(self) -> str:
        """End its input, wait until it is gone, and return what else it said."""
        try:
            return self._process.communicate(timeout=20)[0]
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.communicate()
            raise

    def __enter__(self) -> "Program":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if self._process.returncode is None:
                self.end()
        finally:
            for pipe in (self._process.stdin, self._process.stdout):
                if pipe is not None:
                    pipe.close()


@dataclass(frozen=True, slots=True)
class Passed:
    """What became of the packets that a host was sent since its impairment began."""

    passed: int
    dropped: int


class Host:
    """One network namespace. What is done to packets is done where they arrive.

    Where they leave would be the wrong place: there the kernel still counts a held packet as the sender's own and sends
    no more until it is gone, and a dropped one is an error that the sender hears of.

    Attributes:
        pid: the process that the namespace belongs to.
    """

    def __init__(self, ends: ExitStack, pid: int, arriving: tuple[str, ...], queue: int = 1) -> None:
        """Work in the namespace of a process.

        Args:
            ends: ends what was started in here.
            pid: the process.
            arriving: chain and match of the packets that arrive.
            queue: number of the netfilter queue for them; one of its own for each Host of a namespace.
        """
        self._ends = ends
        self.pid = pid
        self._arriving, self._queue = arriving, str(queue)
        self._inside = ("nsenter", "--target", str(pid), "--net")
        self._impairment: Program | None = None

    @property
    def namespace(self) -> str:
        """The kernel's name of it."""
        return namespace_of(str(self.pid))

    def run(self, *command: str) -> str:
        """Run a command in here and return what it printed."""
        done = subprocess.run((*self._inside, *command), capture_output=True, text=True, timeout=20, check=False)
        assert done.returncode == 0, f"{' '.join(command)}: {done.stderr}"
        return done.stdout

    def start(self, *command: str) -> Program:
        """Start a program in here; it ends with the two hosts at the latest."""
        return self._ends.enter_context(Program(*self._inside, *command))

    def impair(self, delay_ms: float, jitter_ms: float, loss: float, rate_kbit_s: float = 0.0) -> Passed:
        """Delay each packet that arrives by a normal distribution, lose a share of them, and limit their rate."""
        if self._impairment is None:
            self._impairment = self.start(os.environ["IMPAIRMENT_PYTHON"], str(_IMPAIRMENT), self._queue)
            assert self._impairment.hear() == "ready"
            self.run("iptables", "-A", *self._arriving, "-j", "NFQUEUE", "--queue-num", self._queue)
        self._impairment.say(f"{delay_ms} {jitter_ms} {loss} {rate_kbit_s}")
        return Passed(*(int(word) for word in self._impairment.hear().split()))

    def cut(self) -> None:
        """Drop every packet that arrives from now on, without notice."""
        self.run("iptables", "-I", *self._arriving, "-j", "DROP")

    def heal(self) -> None:
        """Take back what `cut` did."""
        self.run("iptables", "-D", *self._arriving, "-j", "DROP")


def new_host(ends: ExitStack) -> Host:
    """A host of its own; it lives as long as a process that reads its input from this one."""
    holder = ends.enter_context(Program("unshare", "--net", "sh", "-c", "ip link set lo up && echo up && exec cat"))
    holder.hear()
    return Host(ends, holder.pid, ("INPUT", "-i", _CABLE))


@dataclass(frozen=True, slots=True)
class TwoHosts:
    """The remote site's host and the operator's, with a cable between them."""

    remote: Host
    operator: Host

    def impair(self, delay_ms: float, jitter_ms: float, loss: float, rate_kbit_s: float = 0.0) -> Passed:
        """Impair both directions, each by itself; the numbers are of both together."""
        both = [host.impair(delay_ms, jitter_ms, loss, rate_kbit_s) for host in (self.remote, self.operator)]
        return Passed(sum(one.passed for one in both), sum(one.dropped for one in both))


Way = Callable[[TwoHosts, Path], str]
"""Joins the hosts, with files in a folder; returns the remote site's address, the same at both hosts."""


@contextmanager
def two_hosts() -> Iterator[TwoHosts]:
    """Set the two hosts up, and take everything down again."""
    with ExitStack() as ends:
        remote, operator = new_host(ends), new_host(ends)
        remote.run("ip", "link", "add", _CABLE, "type", "veth", "peer", "name", _CABLE, "netns", str(operator.pid))
        for host, address in ((remote, REMOTE), (operator, OPERATOR)):
            host.run("ip", "address", "add", f"{address}/24", "dev", _CABLE)
            host.run("ip", "link", "set", _CABLE, "up")
        yield TwoHosts(remote, operator)
