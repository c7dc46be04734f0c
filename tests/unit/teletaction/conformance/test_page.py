"""docs/protocols.md lists the duties that the command tries, under the same numbers and in the same words."""

import pytest

from teletaction.conformance.checklist import Checklist
from teletaction.conformance.examination import CHECKLISTS
from tests.conftest import PROTOCOLS


@pytest.mark.parametrize("checklist", CHECKLISTS, ids=lambda checklist: checklist.title)
def test_the_page_has_the_checklist(checklist: Checklist[object]) -> None:
    page = PROTOCOLS.read_text("utf-8")
    assert checklist.table() in page, "python -m teletaction.conformance prints the tables of part 9"


def test_every_duty_of_the_page_is_tested() -> None:
    part = PROTOCOLS.read_text("utf-8").split("## 9. Firmware duties")[1].split("**What only a person can try**")[0]
    listed = [line.split("|")[1].strip() for line in part.splitlines() if line.startswith("| ") and line[2] != "|"]
    assert [number for number in listed if number] == [d.number for checklist in CHECKLISTS for d in checklist.duties]
