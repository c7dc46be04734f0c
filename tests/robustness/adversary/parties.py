"""The parties at a session, with a key folder each, and the command that lets one of them attack."""

import json
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from common.link.keys import Role, TrustedKeys, create_keys, load_keys
from common.wire.streams import SITE_STREAMS
from teletaction.session.processes import die_with_parent

STRANGER, OBSERVER, SECOND, COPY = "stranger", "observer", "second", "copy"
ROLES = (STRANGER, OBSERVER, SECOND, COPY)
"""Who attacks: nobody's key, a trusted observer's, a trusted second operator's, and a copy of the operator's key."""
READS = -1


class Attack(NamedTuple):
    """Who attacks, with packets of which size, bytes, and how long, s.

    A size of 0 stands for valid small packets, READS for a reader at every port that reads nothing until the end.
    """

    role: str
    size: int
    seconds: float


@dataclass(frozen=True, slots=True)
class Parties:
    """Key folders of both sites, with the other parties' folders beside them.

    Attributes:
        remote: key folder of the remote site.
        operator: key folder of the operator's site.
        others: folder of the other parties' key folders.
        ports: TCP port on loopback of each target: the link's streams, `desk` and `feed`.
    """

    remote: Path
    operator: Path
    others: Path
    ports: Mapping[str, int]

    def introduce(self) -> None:
        """Make a key for each party; the remote site trusts the observer and the second operator."""
        trusted = TrustedKeys(self.remote)
        for role in (STRANGER, OBSERVER, SECOND):
            public = create_keys(self.others / role)
            if role != STRANGER:
                trusted.trust(role, public, Role.OBSERVER if role == OBSERVER else Role.PARTNER)

    @contextmanager
    def attacking(self, *attacks: Attack) -> "Iterator[list[subprocess.Popen[str]]]":
        """Run a process for each attack; at the end none of them runs any more."""
        running = []
        try:
            for attack in attacks:
                running.append(self._begin(attack))  # noqa: PERF401 - those before one that fails are ended as well
            yield running
        finally:
            for process in running:
                process.kill()
            for process in running:
                process.wait()
                if process.stdout is not None:
                    process.stdout.close()

    def _begin(self, attack: Attack) -> "subprocess.Popen[str]":
        folder = self.operator if attack.role == COPY else self.others / attack.role
        return subprocess.Popen(
            [
                *(sys.executable, "-m", "tests.robustness.adversary.run_flood"),
                *(attack.role, str(attack.size), str(attack.seconds), str(folder)),
                *(load_keys(folder).public for folder in (self.remote, self.operator)),
                *(f"{target}={port}" for target, port in self.ports.items()),
            ],
            stdout=subprocess.PIPE,
            text=True,
            preexec_fn=die_with_parent,  # noqa: PLW1509 - no other thread of the caller runs Python
        )


def report(attacker: "subprocess.Popen[str]") -> dict[str, Any]:
    """The report of an attacker at its end; an attacker that failed is an error."""
    text, _ = attacker.communicate()
    assert attacker.returncode == 0, f"an attacker ended with {attacker.returncode}"
    found: dict[str, Any] = json.loads(text)
    return found


def link_ports(base_port: int) -> dict[str, int]:
    """The ports of a link's streams."""
    return {stream.name: base_port + stream.port for stream in SITE_STREAMS.values()}
