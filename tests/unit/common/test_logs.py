"""Log lines of both forms: each a line, each with its times, and whatever context a caller gives."""

import json
import logging
import subprocess
import sys
import time
from datetime import UTC, datetime

import pytest

from common.logs import JsonLines, spoken

PROGRAM = """
import logging, sys, threading, warnings
from common.logs import log_to_stderr
log_to_stderr("remote", {form!r})
logging.getLogger("common.link.link").warning("refused %s", "x", extra={{"stream": "touch", "session": 7}})
logging.getLogger("can").error("a library's chatter")
{then}
"""


def run(form: str, then: str = "") -> list[str]:
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM.format(form=form, then=then)],
        capture_output=True,
        text=True,
        timeout=50,
        check=False,
    )
    assert done.stdout == ""
    return done.stderr.splitlines()


def test_a_json_line_has_both_times_and_the_context_beside_them() -> None:
    before = (time.monotonic(), datetime.now(UTC))
    forged = dict.fromkeys(("level", "logger", "process", "time_utc", "monotonic_s"), "never")
    record = logging.makeLogRecord(
        forged
        | {"name": "a.b", "levelname": "INFO", "msg": "%s is %d", "args": ("thumb", 3), "created": time.time()}
        | {"finger": "thumb", "session": 12}
    )
    line = json.loads(JsonLines("operator").format(record))
    after = (time.monotonic(), datetime.now(UTC))
    assert (line["level"], line["process"], line["logger"], line["message"]) == (
        "info",
        "operator",
        "a.b",
        "thumb is 3",
    )
    assert (line["finger"], line["session"]) == ("thumb", 12)
    assert "never" not in line.values(), "context takes the place of nothing that every line has"
    assert isinstance(line["monotonic_s"], float)
    assert before[0] - 0.001 <= line["monotonic_s"] <= after[0] + 0.001
    written = datetime.fromisoformat(str(line["time_utc"]))
    assert (before[1].timestamp() - 0.001) <= written.timestamp() <= (after[1].timestamp() + 0.001)
    assert written.utcoffset() is not None


def test_plain_lines_keep_their_form() -> None:
    (line,) = run("text")
    words = line.split(" ", 4)
    assert float(words[0]) > 0.0
    assert words[1:] == ["remote", "WARNING", "common.link.link:", "refused x"]


@pytest.mark.parametrize(
    ("then", "says"),
    [
        ("warnings.warn('old')", "old"),
        ("raise RuntimeError('broken')", "broken"),
        ("t = threading.Thread(target=lambda: 1 / 0); t.start(); t.join()", "ZeroDivisionError"),
    ],
)
def test_every_json_line_is_json(then: str, says: str) -> None:
    first, last = (json.loads(line) for line in run("json", then))
    assert (first["message"], first["stream"], first["session"]) == ("refused x", "touch", 7)
    assert says in last["message"] + last.get("exception", "")
    assert last["process"] == "remote"


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ('{"level": "critical", "message": "no key"}', "no key"),
        ("teletaction: no key", "teletaction: no key"),
        ("[1, 2]", "[1, 2]"),
        ("17", "17"),
        ('{"other": 1}', '{"other": 1}'),
        ("", ""),
    ],
)
def test_both_forms_have_the_same_content(line: str, says: str) -> None:
    assert spoken(line) == says
