"""The operator whose session it is may talk alone; every operator may while that is unknown."""

import json
from pathlib import Path
from typing import Any

import pytest

from common.link.keys import fingerprint
from remote_site.voice.session_holder import SessionHolder

OPERATOR, SECOND = "a" * 40, "b" * 40
NOW_NS = 10**12
HELD: dict[str, Any] = {"time_ns": NOW_NS, "state": "engaged", "operator": fingerprint(OPERATOR)}


def looked(status: Path | None) -> SessionHolder:
    holder = SessionHolder(status)
    holder.look(NOW_NS + 10**9)
    return holder


def test_only_the_operator_of_the_session_may_talk(tmp_path: Path) -> None:
    (status := tmp_path / "remote.json").write_text(json.dumps(HELD), "utf-8")
    holder = looked(status)
    assert holder.admits(OPERATOR)
    assert not holder.admits(SECOND)
    holder.look(NOW_NS + 6 * 10**9)
    assert holder.admits(SECOND), "the remote site hangs"


@pytest.mark.parametrize(
    "content",
    [
        json.dumps({**HELD, "operator": ""}),
        json.dumps({"time_ns": NOW_NS, "state": "connected"}),
        json.dumps({**HELD, "state": "ended"}),
        json.dumps({**HELD, "time_ns": NOW_NS + 10**12}),
        "{",
        "[]",
        None,
    ],
)
def test_without_a_known_session_every_operator_may_talk(content: str | None, tmp_path: Path) -> None:
    status = tmp_path / "remote.json"
    if content is not None:
        status.write_text(content, "utf-8")
    assert looked(status).admits(SECOND)


def test_without_a_status_file_every_operator_may_talk() -> None:
    assert looked(None).admits(SECOND)
