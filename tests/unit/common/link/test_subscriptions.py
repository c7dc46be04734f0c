"""The search for readers that subscribe repeatedly takes a small share of a loop's time, however long it lasts."""

import time
from typing import cast

import pytest
import zmq

from common.link import subscriptions
from common.link.subscriptions import Subscriptions

SEARCH_S = 0.01


class Growing:
    """A socket whose number of subscriptions grows at each look."""

    def __init__(self) -> None:
        self.count = 1

    def getsockopt(self, option: int) -> int:
        self.count += 1
        return self.count


def test_long_searches_leave_the_loop_its_time(monkeypatch: pytest.MonkeyPatch) -> None:
    searches = []

    def search(local_port: int, most_bytes: int) -> int:
        time.sleep(SEARCH_S)
        searches.append(local_port)
        return 0

    monkeypatch.setattr(subscriptions, "end_talkers", search)
    subscribers = Subscriptions(cast("zmq.Socket[bytes]", Growing()), 5602)
    end_s = time.monotonic() + 0.5
    while time.monotonic() < end_s:
        subscribers.step()
        time.sleep(0.001)
    assert 2 <= len(searches) <= 1 + 0.5 / ((1.0 + subscriptions._REST) * SEARCH_S)
