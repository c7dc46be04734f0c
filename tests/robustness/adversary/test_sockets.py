"""All parties flood every port of a real session, and pause every reader: no process ends, and STOP is carried out."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from common.link.curve import LinkProblem
from common.link.keys import load_keys
from common.link.local_control import ask_desk
from common.wire.packets import MAX_PACKET
from teletaction.session.processes import die_with_parent
from tests.ports import free_port
from tests.robustness.adversary.parties import COPY, READS, ROLES, Attack, Parties, link_ports, report
from tests.robustness.hardening.served import Keys

pytestmark = [pytest.mark.hardening, pytest.mark.timeout(120)]

FLOOD_S = 4.0
PAUSE_S = 5.0
STOP_S = 0.3
MOST_GROWTH_MIB = 30.0
COPIED = "the operator's key is in use at two places at once"


class Session:
    """A victim in a process of its own, seen through the desk."""

    def __init__(self, parties: Parties) -> None:
        self.parties = parties
        self._keys = load_keys(parties.operator)
        self.process = subprocess.Popen(
            [
                *(
                    sys.executable,
                    "-m",
                    "tests.robustness.adversary.victim",
                    str(parties.remote),
                    str(parties.operator),
                ),
                *(str(parties.ports[name]) for name in ("motion", "desk", "feed")),
            ],
            stdin=subprocess.PIPE,
            preexec_fn=die_with_parent,  # noqa: PLW1509 - no other thread of the caller runs Python
        )

    def ask(self, verb: str = "status", **details: Any) -> dict[str, Any]:
        """Ask at the desk; an ended process is an error at once."""
        assert self.process.poll() is None, f"the process ended with {self.process.returncode}"
        return ask_desk(self.parties.ports["desk"], self._keys, verb, details)

    def until(self, reached: Callable[[dict[str, Any]], object], seconds: float = 15.0) -> dict[str, Any]:
        """The status of local control once a condition holds."""
        end_s = time.monotonic() + seconds
        while True:
            try:
                seen = self.ask()
            except LinkProblem:  # a busy machine: asked again
                seen = {}
            if seen and reached(seen):
                return seen
            assert time.monotonic() < end_s, seen
            time.sleep(0.02)

    def engage(self) -> dict[str, Any]:
        """Clear what is latched and engage, as a person would; again where an attacker latches it once more."""

        def engaged(seen: dict[str, Any]) -> bool:
            if not seen["engaged"]:
                self.ask("clear_fault")
                self.ask("engage")
            return bool(seen["engaged"])

        return self.until(engaged)

    def stop(self) -> float:
        """Ask for an emergency stop; returns how long it took until the remote site had latched it, s."""
        self.ask("estop", asked_ns=time.monotonic_ns())
        return float(self.until(lambda seen: seen["stop_s"] is not None)["stop_s"])


@pytest.fixture
def session(keys: Keys, base_port: int, tmp_path: Path) -> Iterator[Session]:
    ports = {**link_ports(base_port), "desk": free_port(), "feed": free_port()}
    parties = Parties(keys.remote, keys.operator, tmp_path / "parties", ports)
    parties.introduce()
    victim = Session(parties)
    try:
        victim.engage()
        yield victim
        assert victim.process.poll() is None
    finally:
        victim.process.kill()
        victim.process.communicate()


@pytest.mark.parametrize("role", ROLES)
def test_a_flood_of_every_port_ends_no_process_and_a_stop_is_latched(session: Session, role: str) -> None:
    before_mib = session.ask()["own_mib"]
    with session.parties.attacking(*(Attack(role, size, FLOOD_S) for size in (0, MAX_PACKET))) as attackers:
        time.sleep(FLOOD_S / 2)
        stop_s = session.stop()
        sent = [report(attacker)["sent"] for attacker in attackers]
    after = session.engage()
    print(f"{role}: stop {stop_s * 1e3:.0f} ms, {after}, sent {sent}")
    assert stop_s < STOP_S
    assert after["own_mib"] - before_mib < MOST_GROWTH_MIB
    assert after["moved_m"] == 0.0, "somebody else than the operator moved the telemanipulator"
    strange = [fault for fault in after["faults"] if not fault.startswith("emergency stop by the operator")]
    assert all(role == COPY and fault.startswith(COPIED) for fault in strange), strange


@pytest.mark.parametrize("stopped", [True, False], ids=["process stopped", "readers pause"])
def test_readers_that_pause_end_no_process(session: Session, stopped: bool) -> None:
    """Readers of every role read nothing, then both sites read nothing for 5 s while the ports are flooded."""
    before_mib = session.ask()["own_mib"]
    attacks = [Attack(role, READS, PAUSE_S + 2.0) for role in ROLES]
    attacks += [Attack("second", 0, PAUSE_S + 2.0), Attack("observer", MAX_PACKET, PAUSE_S + 2.0)]
    with session.parties.attacking(*attacks) as attackers:
        time.sleep(1.0)
        if stopped:
            paused = [session.process.pid, *(reader.pid for reader in attackers[:2])]
            for pid in paused:
                os.kill(pid, signal.SIGSTOP)
            time.sleep(PAUSE_S)
            for pid in paused:
                os.kill(pid, signal.SIGCONT)
        else:
            session.ask("annotate", pause_s=PAUSE_S)
            time.sleep(PAUSE_S)
        waited = [report(attacker) for attacker in attackers]
    after = session.engage()
    print(after, waited)
    assert after["own_mib"] - before_mib < MOST_GROWTH_MIB
    assert session.stop() < STOP_S
