"""The log of an export distinguishes the end of an alarm from its begin, and marks a withdrawn finding."""

from typing import Any

import pytest

from teletaction.export.log_entries import log_entry
from teletaction.export.named_recording import NamedMessage

ALARM = {"id": "plate", "text": "Index: plate 42.3 °C", "since_s": 3.0}
FOUND = {"id": 1, "text": "warm, 36.4 ± 0.2 °C"}


@pytest.mark.parametrize(
    ("topic", "fields", "entry"),
    [
        ("console/alarm", ALARM | {"ended_s": None}, (3, "Index: plate 42.3 °C")),
        ("console/alarm", ALARM | {"ended_s": 9.0}, (2, "ended: Index: plate 42.3 °C")),
        ("console/finding", FOUND, (2, "warm, 36.4 ± 0.2 °C")),
        ("console/finding", FOUND | {"withdrawn": ""}, (2, "warm, 36.4 ± 0.2 °C")),
        ("console/finding", FOUND | {"withdrawn": "pressed twice"}, (2, "withdrawn: warm, 36.4 ± 0.2 °C")),
    ],
)
def test_an_entry_says_what_its_record_changes(topic: str, fields: dict[str, Any], entry: tuple[int, str]) -> None:
    made = log_entry(NamedMessage(topic, 1, 10**9, fields))
    assert made is not None
    assert (made["level"], made["message"]) == entry
