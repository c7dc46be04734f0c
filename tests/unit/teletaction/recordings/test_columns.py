"""The messages of a stream are collected as arrays, in parts."""

from typing import Any

import numpy as np
import pytest

from teletaction.recordings import columns
from teletaction.recordings.columns import Columns, Floats, as_floats


def values(messages: list[Any]) -> dict[str, Floats]:
    return {
        "one": as_floats([message[0] for message in messages]),
        "five": as_floats([message[1] for message in messages]),
    }


@pytest.mark.parametrize("count", [1, 2, 3, 4, 9])
def test_the_parts_give_the_same_values_as_all_messages_at_once(count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(columns, "_AT_ONCE", 2)
    messages = [(None if n == 1 else float(n), tuple(range(n, n + 5))) for n in range(count)]
    collected = Columns(values)
    for message in messages:
        collected.append(message)
        assert len(collected._messages) < 2, "an object takes ten times the memory"
    for name, found in collected.arrays().items():
        np.testing.assert_array_equal(found, values(messages)[name])
        assert found.dtype == np.float64


def test_a_stream_without_messages_has_its_names() -> None:
    found = Columns(values).arrays()
    assert {name: len(column) for name, column in found.items()} == {"one": 0, "five": 0}
