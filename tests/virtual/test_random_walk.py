"""A seeded walk over all faults, judged at every tick; afterwards the work must resume."""

import random
from collections.abc import Callable

import pytest

from common.limits import AGE_DEFAULT_S
from teletaction.testbed.network import STREAMS, TO_OPERATOR, TO_REMOTE
from tests.virtual.conftest import MakeSession
from tests.virtual.session import VirtualSession

pytestmark = pytest.mark.long

STEPS = 14
LONGEST_S = 2.5
MENDED_S = 30.0
FAULTS = [
    *(
        f"{side}: {fault} {device}"
        for side, device in (("remote", "index texture"), ("remote", "index thermal"), ("operator", "index tacttip"))
        for fault in ("unplug", "silence", "deafen", "babble")
    ),
    *(f"{side}: {fault}" for side in ("remote", "operator") for fault in ("unplug can", "deafen can", "bus_off")),
    *(f"{side}: thermistor index {how}" for side in ("remote", "operator") for how in ("open", "short", "frozen")),
    "remote: disobey",
    "remote: disobey drift",
]
"""In the words of `sim_sensors.faults.faults`."""


class Walk:
    """Draws the next event; `story` lists all of them."""

    def __init__(self, session: VirtualSession, seed: int) -> None:
        self.story: list[str] = []
        self._session = session
        self._chance = random.Random(f"walk {seed}")
        self._steps: list[Callable[[], str]] = [
            self._impair,
            self._impair,
            self._cut,
            self._heal,
            self._step_clock,
            self._break,
            self._break,
            self._mend,
            self._stop,
            self._restart,
            self._restart,
        ]

    def go(self) -> None:
        """Let something happen, and then time pass."""
        event = self._chance.choice(self._steps)()
        self.story.append(f"{self._session.time_s:.3f} s: {event}")
        self._session.run(round(self._chance.uniform(0.05, LONGEST_S), 3))

    def end(self) -> None:
        """Mend all, and clear what is latched."""
        self._heal()
        self._mend()
        self._session.run(3.0)
        for _ in range(3):
            self._session.clear_faults()
            self._session.run(1.0)
        self._session.engage()
        self.story.append(f"{self._session.time_s:.3f} s: all mended")

    def _impair(self) -> str:
        chance = self._chance
        changes: dict[str, float] = chance.choice(
            [
                {"delay_s": chance.uniform(0.0, 0.3), "jitter_s": chance.uniform(0.0, 0.1)},
                {"drop": chance.uniform(0.0, 0.8)},
                {"duplicate": 0.3, "reorder": 0.3, "reorder_s": 0.020},
                {"replay": 0.2},
                {"stalled": True},
                {"stalled": False},
            ]
        )
        direction = chance.choice([None, TO_REMOTE, TO_OPERATOR])
        stream = chance.choice([None, *STREAMS])
        self._session.network.impair(direction, stream, **changes)
        return f"{direction or 'both ways'}, {stream or 'every stream'}: {changes}"

    def _cut(self) -> str:
        direction = self._chance.choice([None, TO_REMOTE, TO_OPERATOR])
        self._session.network.impair(direction, cut=True)
        return f"cut {direction or 'both ways'}"

    def _heal(self) -> str:
        self._session.network.heal()
        return "a good network"

    def _step_clock(self) -> str:
        side, seconds = self._chance.choice(["remote", "operator"]), self._chance.choice([10.0, -10.0])
        clock = self._session.remote_clock if side == "remote" else self._session.operator_clock
        clock.offset_s += seconds
        return f"clock of the {side} site {seconds:+.0f} s"

    def _break(self) -> str:
        fault = self._chance.choice(FAULTS)
        self._session.break_device(fault)
        return fault

    def _mend(self) -> str:
        self._session.mend_devices()
        return "all devices mended"

    def _stop(self) -> str:
        self._session.emergency_stop()
        return "emergency stop"

    def _restart(self) -> str:
        self._session.clear_faults()
        self._session.run(0.5)
        self._session.engage()
        return "faults cleared, engaged again"


@pytest.mark.timeout(180)
@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.hardening) for seed in range(1, 24))])
def test_random_faults_break_no_limit_or_hold_time_and_the_work_resumes(make_session: MakeSession, seed: int) -> None:
    # On a slow network the clocks are known to half a round trip, which is accepted up to the age itself.
    session = make_session(seed, clocks_agree_s=AGE_DEFAULT_S)
    walk = Walk(session, seed)
    try:
        session.work()
        for _ in range(STEPS):
            walk.go()
        walk.end()
        session.resume(MENDED_S)
    except AssertionError as error:
        error.add_note("\n".join(walk.story))
        raise
