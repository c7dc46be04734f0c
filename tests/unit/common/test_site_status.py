"""A site reports the freshness of its input."""

from types import SimpleNamespace
from typing import Any

import pytest

from common.limits import GAP_S
from common.link.packet_filter import PacketFilter
from common.link.session_state import Session
from common.site_status import in_brief, staleness

NOW_NS = 1_000_000_000_000


def end(engaged: bool, last_ns: int | None) -> Any:
    """An end of a session whose far side may never have sent a packet, and so never was engaged, too."""
    session = SimpleNamespace(engaged=engaged)
    acceptance = PacketFilter(150_000_000, last_ns=last_ns)
    return SimpleNamespace(session=session, both_engaged=engaged and last_ns is not None, acceptance=acceptance)


@pytest.mark.parametrize(
    ("engaged", "gap_s", "said"),
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
def test_only_an_engaged_site_reports_missing_input(engaged: bool, gap_s: float | None, said: str) -> None:
    last_ns = None if gap_s is None else NOW_NS - round(gap_s * 1e9)
    assert staleness(end(engaged, last_ns), "touch", NOW_NS, GAP_S) == said


def engaged_end(*, both: bool, gap_s: float | None) -> Any:
    """An end of an engaged session whose far side was last heard `gap_s` ago."""
    session = Session()
    session.connect(7)
    session.engage()
    session.heard(0, GAP_S, "touch")
    session.heard(None if gap_s is None else round(gap_s * 1e9), GAP_S, "touch")
    stopping = SimpleNamespace(asked_ns=None, after_s={})
    return SimpleNamespace(session=session, both_engaged=both, stopped="", stopping=stopping)


@pytest.mark.parametrize(
    ("both", "gap_s", "said"),
    [
        (True, 0.01, "engaged"),
        (True, GAP_S, "engaged"),
        (True, GAP_S + 1e-3, "lost"),
        (True, 1.2, "lost"),
        (False, 0.01, "engaging"),
        (False, 1.2, "lost"),
        (False, None, "engaging"),
    ],
)
def test_a_site_reports_engaged_only_while_outputs_may_act(both: bool, gap_s: float | None, said: str) -> None:
    assert in_brief(engaged_end(both=both, gap_s=gap_s), "")["state"] == said
