"""Sessions on a virtual clock for the tests of this folder."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack

import pytest

from common.limits import AGE_DEFAULT_S
from common.recording.recorder import Recorder
from teletaction.testbed.memory_feed import MemoryFeed
from tests.virtual.judge import CLOCKS_AGREE_S, judges
from tests.virtual.session import VirtualSession, virtual_session

MakeSession = Callable[..., VirtualSession]
ON_THE_WAY_S = 1.7
"""The hand reaches the object later than this, s."""


@pytest.fixture
def make_session() -> Iterator[MakeSession]:
    """Makes sessions that are judged at every tick."""
    with ExitStack() as opened:

        def make(
            seed: int = 0,
            max_age_s: float = AGE_DEFAULT_S,
            clocks_agree_s: float = CLOCKS_AGREE_S,
            recorders: Mapping[str, Recorder] | None = None,
            feed: MemoryFeed | None = None,
        ) -> VirtualSession:
            session = opened.enter_context(virtual_session(seed, max_age_s, recorders, feed))
            session.watch += judges(max_age_s, clocks_agree_s)
            return session

        yield make


@pytest.fixture
def session(make_session: MakeSession) -> VirtualSession:
    """A session with a good network, from its very beginning."""
    return make_session()


@pytest.fixture
def working(session: VirtualSession) -> VirtualSession:
    """A session in the middle of a stroke, with force, vibration and heat; the hand's way there passes coarsely."""
    session.run_coarsely(ON_THE_WAY_S)
    session.work()
    session.run(0.5)
    assert session.at_work
    return session
