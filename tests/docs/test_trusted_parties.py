"""Each line of the page of trusted parties names a test that exists."""

import re

from tests.places import ROOT

PAGE = ROOT / "docs" / "trusted-parties.md"
_ROWS = [line.strip("|\n ").split(" | ") for line in PAGE.read_text("utf-8").splitlines() if line.startswith("| ")]
LINES = [row for row in _ROWS if len(row) == 4 and row[0] != "party"]
PARTIES = {row[0] for row in _ROWS if len(row) == 2}


def test_each_line_names_a_party_and_a_test() -> None:
    assert len(LINES) > 20
    for party, *_, named in LINES:
        assert any(party.startswith(each) for each in (*PARTIES, "any trusted key", "second operator, observer")), party
        found = re.fullmatch(r"`(tests/[\w/]+\.py)(?:::(\w+))?`", named)
        assert found, named
        text = (ROOT / found[1]).read_text("utf-8")
        name = found[2]
        assert name is None or f"def {name}(" in text or f"\n{name} = " in text, named
