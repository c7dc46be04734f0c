"""The report of an examination: what the command wrote is offered, and why there is none is said."""

import asyncio
import sys
from pathlib import Path

import pytest

from operator_site.console.examination import reporting
from operator_site.console.examination.reporting import Reporting

pytestmark = pytest.mark.long
WRITE = (sys.executable, "-c", "import sys; open(sys.argv[1], 'w').write('<p>')", "{report}")


@pytest.fixture(autouse=True)
def at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reporting, "SETTLED_S", 0.0)


def test_what_the_command_wrote_is_offered_and_never_written_over(tmp_path: Path) -> None:
    reports = Reporting(WRITE, tmp_path / "reports")
    assert asyncio.run(reports.write("P-0417", [])) == "/report/P-0417.html"
    assert asyncio.run(reports.write("P-0417", [])) == "/report/P-0417-1.html"
    assert asyncio.run(reports.write("../P 1/<x>", [])) == "/report/___P_1__x_.html"
    names = {path.name for path in (tmp_path / "reports").iterdir()}
    assert names == {"P-0417.html", "P-0417-1.html", "___P_1__x_.html"}


def test_examinations_that_end_shortly_after_each_other_keep_a_report_each(tmp_path: Path) -> None:
    reports = Reporting(WRITE, tmp_path / "reports")

    async def both() -> set[str]:
        return {*await asyncio.gather(reports.write("P-0417", []), reports.write("P-0417", []))}

    assert asyncio.run(both()) == {"/report/P-0417.html", "/report/P-0417-1.html"}


@pytest.mark.parametrize(
    ("command", "match"),
    [
        ((), "no report is configured"),
        ((sys.executable, "-c", "import sys; sys.exit('teletaction: no such recording')"), "no such recording"),
        ((sys.executable, "-c", ""), "the command ended with 0"),
        (("/no/such/command",), "No such file"),
    ],
)
def test_why_there_is_none_is_said(tmp_path: Path, command: tuple[str, ...], match: str) -> None:
    with pytest.raises(OSError, match=match):
        asyncio.run(Reporting(command, tmp_path).write("P-0417", []))


def test_the_command_is_given_every_file_that_holds_findings(tmp_path: Path) -> None:
    write = (sys.executable, "-c", "import sys; open(sys.argv[-1], 'w').write(' '.join(sys.argv[1:-1]))")
    files = [tmp_path / "console.mcap", tmp_path / "console-1.mcap"]
    reports = Reporting((*write, "operator.mcap", "{record}", "{report}"), tmp_path)
    asyncio.run(reports.write("P-0417", files))
    assert (tmp_path / "P-0417.html").read_text("utf-8") == f"operator.mcap {files[0]} {files[1]}"
