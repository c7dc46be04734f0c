"""What a site says of the freshness of what it acts on."""

from types import SimpleNamespace
from typing import Any

import pytest

from common.acceptance import Acceptance
from common.limits import GAP_S
from common.site_report import staleness

NOW_NS = 1_000_000_000_000


def end(acts: bool, last_ns: int | None) -> Any:
    return SimpleNamespace(both_engaged=acts, acceptance=Acceptance(150_000_000, last_ns=last_ns))


@pytest.mark.parametrize(
    ("acts", "gap_s", "said"),
    [
        (False, None, ""),
        (False, 9.0, ""),
        (True, None, "no touch has come yet"),
        (True, 0.0, ""),
        (True, GAP_S, ""),
        (True, GAP_S + 1e-3, "no touch for 0.10 s"),
        (True, 2.5, "no touch for 2.50 s"),
    ],
)
def test_only_a_site_that_acts_waits_for_something(acts: bool, gap_s: float | None, said: str) -> None:
    last_ns = None if gap_s is None else NOW_NS - round(gap_s * 1e9)
    assert staleness(end(acts, last_ns), "touch", NOW_NS, GAP_S) == said
