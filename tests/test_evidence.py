"""The chain from hazards to faults has no loose end on either side."""

import ast
import re
from importlib.util import find_spec
from pathlib import Path

from common import limits
from robustness.faults import GROUPS
from tests.evidence import HAZARDS, page

ROOT = Path(__file__).parents[1]


def test_every_limit_belongs_to_a_hazard() -> None:
    named = {name for hazard in HAZARDS for name in hazard.limits}
    assert named == {name for name in vars(limits) if name.isupper()} - {"PLATE_PROFILES"}


def test_every_module_of_a_gate_belongs_to_a_hazard() -> None:
    listed = re.findall(r"^(?:OPERATOR|PATIENT)_GATE := ((?:.*\\\n)*.*)$", (ROOT / "Makefile").read_text("utf-8"), re.M)
    gates = set(re.findall(r"\w+\.\w+", " ".join(listed)))
    assert len(gates) > 10
    assert gates <= {module for hazard in HAZARDS for module in hazard.code}


def test_every_fault_belongs_to_one_hazard() -> None:
    tried = [key for hazard in HAZARDS for key in hazard.faults]
    assert sorted(tried) == sorted(fault.key for faults in GROUPS.values() for fault in faults)


def test_whatever_is_named_is_there() -> None:
    for hazard in HAZARDS:
        assert hazard.code, hazard.name
        assert hazard.tests, hazard.name
        for module in hazard.code:
            assert find_spec(module), module
        for test in hazard.tests:
            file, _, name = test.partition("::")
            tree = ast.parse((ROOT / file).read_text("utf-8"))
            assert not name or name in {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}, test


def test_the_page_is_of_this_table() -> None:
    written = (ROOT / "docs" / "evidence.md").read_text("utf-8")
    assert written == page(), "python -m tests.evidence > docs/evidence.md"
