"""The chain from hazards to faults is complete in both directions."""

import ast
import re
from importlib.util import find_spec

from common import limits
from robustness.faults import GROUPS
from tests.evidence import HAZARDS, page
from tests.places import ROOT

RECORDS = {
    "operator_site.safety.gated_output",
    "operator_site.safety.limit_flags",
    "remote_site.safety.limit_flags",
    "remote_site.safety.servo",
}
"""They hold values and decide nothing."""


def test_every_limit_belongs_to_a_hazard() -> None:
    named = {name for hazard in HAZARDS for name in hazard.limits}
    assert named == {name for name in vars(limits) if name.isupper()} - {"PLATE_PROFILES"}


def test_every_module_of_a_gate_belongs_to_a_hazard() -> None:
    folders = re.findall(r"^GATES := (.*)$", (ROOT / "Makefile").read_text("utf-8"), re.MULTILINE)[0].split()
    files = [path for folder in folders for path in (ROOT / folder.replace(".", "/")).glob("[!_]*.py")]
    gates = {".".join(path.relative_to(ROOT).with_suffix("").parts) for path in files}
    assert len(gates) > 10
    assert gates - RECORDS <= {module for hazard in HAZARDS for module in hazard.code}


def test_every_fault_belongs_to_one_hazard() -> None:
    tried = [key for hazard in HAZARDS for key in hazard.faults]
    assert sorted(tried) == sorted(fault.key for faults in GROUPS.values() for fault in faults)


def test_every_named_file_and_test_exists() -> None:
    for hazard in HAZARDS:
        assert hazard.code, hazard.name
        assert hazard.tests, hazard.name
        for module in hazard.code:
            assert find_spec(module), module
        for test in hazard.tests:
            file, _, name = test.partition("::")
            tree = ast.parse((ROOT / file).read_text("utf-8"))
            assert not name or name in {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}, test


def test_the_page_matches_the_table() -> None:
    written = (ROOT / "docs" / "evidence.md").read_text("utf-8")
    assert written == page(), "python -m tests.evidence > docs/evidence.md"
