"""Sessions on a virtual clock, each judged at every tick and shared by the attacks of a module."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from teletaction.testbed.network import Visitor
from tests.robustness.adversary.attacker import Attacker
from tests.virtual.conftest import ON_THE_WAY_S
from tests.virtual.judge import judges
from tests.virtual.session import Truth, VirtualSession, virtual_session

WITHIN_M = 0.29
"""The operator's hand strokes up to 0.285 m; attackers send the telemanipulator to FAR_M."""


def check_whose_motion(_: VirtualSession, now: Truth) -> None:
    """The telemanipulator is where the operator's hand may be, not where attackers send it."""
    assert abs(now.x_m) < WITHIN_M, now


@contextmanager
def judged_session() -> Iterator[VirtualSession]:
    """A session at work; every tick from its beginning is judged."""
    with virtual_session() as session:
        session.watch += [check_whose_motion, *judges()]
        session.run_coarsely(ON_THE_WAY_S)
        session.work()
        yield session


@pytest.fixture
def working() -> Iterator[VirtualSession]:
    """A session of its own."""
    with judged_session() as session:
        yield session


@pytest.fixture(scope="module")
def shared() -> Iterator[VirtualSession]:
    """A session that the tests of a module go through one after the other."""
    with judged_session() as session:
        yield session


def attacker_of(session: VirtualSession, key: str) -> Attacker:
    """An attacker with a trusted key, connected to every stream that the key opens."""
    return Attacker(Visitor(session.network, key), session.operator_host.now_ns)
