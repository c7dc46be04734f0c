"""The page of failures lists every fault of the simulated devices."""

import re

from tests.places import ROOT

PAGE = (ROOT / "docs" / "howto" / "failures.md").read_text("utf-8")
KINDS = (ROOT / "sim_sensors" / "faults" / "kinds.py").read_text("utf-8")


def test_every_fault_of_a_simulated_device_is_listed() -> None:
    kinds = re.findall(r'(?m)^ {8}"(\w+)": (?:Fault\(|_of_parts\()', KINDS)
    assert len(kinds) > 15
    commands = PAGE.partition("| command | what fails |")[2].partition("\n\n")[0]
    assert [kind for kind in kinds if not re.search(rf"`{kind}\b", commands)] == []
