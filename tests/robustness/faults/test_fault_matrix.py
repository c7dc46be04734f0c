"""Every fault of the table, done to a session and judged at the simulated actuators.

Those that need no real process are done on the test bed; with FAULTS=real, to real processes as all others.
With FAULT_PAGE set, what was measured is written there as a page, and as data beside it.
"""

import json
import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from robustness.fault_judge import Finding
from robustness.fault_page import as_data, page
from robustness.faults import GROUPS, run

pytestmark = [pytest.mark.faults, pytest.mark.timeout(900)]

REAL = os.environ.get("FAULTS") == "real"


@pytest.fixture(scope="module")
def findings() -> Iterator[dict[str, dict[str, Finding]]]:
    """What was found so far, by group; written down at the end when everything was tried."""
    found: dict[str, dict[str, Finding]] = {}
    yield found
    target = os.environ.get("FAULT_PAGE")
    if target and set(found) == set(GROUPS):
        every = [finding for group in GROUPS for finding in found[group].values()]
        Path(target).write_text(page(every, REAL), "utf-8")
        Path(target).with_suffix(".json").write_text(json.dumps(as_data(every), indent=1) + "\n", "utf-8")


@pytest.mark.parametrize(("group", "key"), [(group, fault.key) for group, faults in GROUPS.items() for fault in faults])
def test_a_fault_has_the_outcome_of_the_table(findings: dict[str, dict[str, Finding]], group: str, key: str) -> None:
    if group not in findings:
        found = run([group], print, real=REAL)
        findings[group] = {finding.fault.key: finding for finding in found}
    assert findings[group][key].wrong == []


def test_every_fault_has_a_name_of_its_own() -> None:
    keys = [fault.key for faults in GROUPS.values() for fault in faults]
    assert len(set(keys)) == len(keys)
