"""A device with one thing wrong fails in the duty that it breaks, and in no other."""

from collections.abc import Callable

import pytest

import tests.unit.teletaction.conformance.wrong_drives
import tests.unit.teletaction.conformance.wrong_modules
import tests.unit.teletaction.conformance.wrong_nodes  # noqa: F401
from teletaction.conformance.checklist import Verdict
from teletaction.conformance.examination import CHECKLISTS
from tests.unit.teletaction.conformance.examining import came, examined
from tests.unit.teletaction.conformance.spoiled_module import FINGER, WRONG_MODULES
from tests.unit.teletaction.conformance.spoiled_node import WRONG_NODES
from tests.unit.teletaction.conformance.virtual_ends import VirtualModule, VirtualNode

WRONG = [*WRONG_MODULES, *WRONG_NODES]


@pytest.mark.long
@pytest.mark.parametrize(("number", "make"), WRONG, ids=lambda value: getattr(value, "__name__", value))
def test_a_wrong_device_fails_in_its_duty_alone(number: str, make: Callable[[], VirtualModule | VirtualNode]) -> None:
    finger = 0 if number.startswith("P") else FINGER  # the patient's switch belongs to no finger
    assert came(examined(make(), expected_finger=finger), Verdict.FAIL).keys() == {number}


def test_every_duty_has_a_device_that_breaks_it() -> None:
    numbers = [duty.number for checklist in CHECKLISTS for duty in checklist.duties]
    assert len(set(numbers)) == len(numbers)
    assert set(numbers) == {number for number, _ in WRONG}
