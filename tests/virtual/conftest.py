"""Sessions on a virtual clock for the tests of this folder."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack

import pytest

from common.limits import AGE_DEFAULT_S
from common.recording.recorder import Recorder
from teletaction.testbed.memory_feed import MemoryFeed
from tests.virtual.judge import DeviceTimeouts, HoldTimes, Latches, check_limits
from tests.virtual.session import VirtualSession, virtual_session

CLOCKS_AGREE_S = 0.005
"""Half a round trip of a good network, and some. What is acted on may truly be older than the agreed age by as much as
the sites do not know of each other's clocks: half a round trip, whatever its two ways took, at most the age itself."""

MakeSession = Callable[..., VirtualSession]


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
            session.watch += [check_limits, HoldTimes(max_age_s + clocks_agree_s), Latches(), DeviceTimeouts()]
            return session

        yield make


@pytest.fixture
def session(make_session: MakeSession) -> VirtualSession:
    """A session with a good network, from its very beginning."""
    return make_session()


@pytest.fixture
def working(session: VirtualSession) -> VirtualSession:
    """A session in the middle of a stroke, with force, vibration and heat."""
    session.work()
    session.run(0.5)
    assert session.at_work
    return session
