"""Both ends of the real link on two hosts, and what the operator's end found."""

import json
import sys
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

import numpy as np

from common.limits import GAP_S
from common.link.keys import load_keys
from common.link.packet_filter import FUTURE_TOLERANCE_NS
from tests.conftest import Keys
from tests.network.operator_end import EVERY
from tests.network.remote_end import CLOCK_APART_NS
from tests.network.two_hosts import REMOTE, Program, TwoHosts, two_hosts

BASE_PORT = 5600
MEASURED = 2500
"""Packets accepted in each measurement: 5 s of an undisturbed link."""


@dataclass(frozen=True)
class Measured:
    """What the operator's end accepted, in order; times in ns of its clock."""

    sent: int
    arrived_ns: np.ndarray
    sequence: np.ndarray
    source_ns: np.ndarray
    age_ns: np.ndarray
    """As the operator's end knew it."""
    true_age_ns: np.ndarray
    """As this test knows it, which knows both clocks."""
    uncertainty_ns: np.ndarray
    max_age_ns: int
    refused: dict[str, int]

    def row(self, name: str) -> str:
        """One line of the table: ages and gaps in ms, at the median, at 99 %, and the largest."""
        gaps_ns = np.diff(self.arrived_ns)
        numbers = (
            f"{np.percentile(values, 50) / 1e6:8.2f} {np.percentile(values, 99) / 1e6:8.2f} {values.max() / 1e6:8.2f}"
            for values in (self.age_ns, gaps_ns)
        )
        share, too_long = f"{len(self.sequence) / self.sent:6.1%}", int((gaps_ns > GAP_S * 1e9).sum())
        return f"{name:34} {share} {' '.join(numbers)} {too_long:8d}  {self.refused}"


HEAD = f"{'link':34} accept" + "".join(
    f" {name:>8}" for name in ("age p50", "p99", "max", "gap p50", "p99", "max", "too long", "refused")
)


class Bench:
    """The two hosts with an end of the link on each."""

    def __init__(self, keys: Keys, ends: ExitStack) -> None:
        self.hosts: TwoHosts = ends.enter_context(two_hosts())
        self._keys = keys
        self._counted = 0

    def connect(self, address: str = REMOTE, twice: bool = False) -> None:
        """Start both ends and wait until packets are accepted.

        The remote site is at `address` for both. `twice` asks for two connections for touch.
        """
        end = (sys.executable, "-m")
        self.remote = self.hosts.remote.start(
            *end, "tests.network.remote_end", address, str(BASE_PORT), str(self._keys.remote)
        )
        assert self.remote.hear() == "bound"
        public = load_keys(self._keys.remote).public
        self.operator: Program = self.hosts.operator.start(
            *end,
            "tests.network.operator_end",
            address,
            str(BASE_PORT),
            str(self._keys.operator),
            public,
            *["twice"] * twice,
        )
        self.accept(EVERY)

    def accept(self, packets: int) -> None:
        """Wait until this number of further packets was accepted."""
        wanted = self._counted + packets
        while self._counted < wanted:
            self._counted = int(self.operator.hear())

    def finish(self) -> Measured:
        """End both ends and read what they found."""
        report: dict[str, Any] = json.loads(self.operator.end().splitlines()[-1])
        sent = json.loads(self.remote.end())["sent"]
        arrived, sequence, source, age, offset, uncertainty = np.array(report["accepted"], dtype=np.int64).T
        assert (np.abs(offset - CLOCK_APART_NS) <= uncertainty).all(), "the clocks are not where they were found to be"
        true_age = arrived - (source - CLOCK_APART_NS)
        source_ns = source - CLOCK_APART_NS
        return Measured(
            sent, arrived, sequence, source_ns, age, true_age, uncertainty, report["max_age_ns"], report["refused"]
        )


def assert_sound(measured: Measured) -> None:
    """What holds on any network: nothing old, nothing twice, nothing backwards, nothing from the future."""
    assert (measured.age_ns <= measured.max_age_ns).all()
    assert (measured.true_age_ns <= measured.max_age_ns + measured.uncertainty_ns).all()
    assert (measured.true_age_ns >= -(FUTURE_TOLERANCE_NS + 2 * measured.uncertainty_ns)).all()
    assert (np.diff(measured.sequence) > 0).all()
    assert (np.diff(measured.source_ns) > 0).all()
    assert len(measured.sequence) <= measured.sent
