"""A device with one thing wrong fails in the duty that it breaks, and in no other."""

from collections.abc import Callable

import pytest

from teletaction.conformance.checklist import How, Tried, Verdict
from teletaction.conformance.examination import CHECKLISTS, module_on_trial, node_on_trial
from teletaction.conformance.module_talk import ModuleTalk
from teletaction.conformance.node_talk import KINDS, NodeName, NodeTalk
from tests.conformance.spoiled_module import FINGER
from tests.conformance.virtual_ends import VirtualModule, VirtualNode
from tests.conformance.wrong_cut_outs import WRONG_CUT_OUTS
from tests.conformance.wrong_drives import WRONG_DRIVES
from tests.conformance.wrong_exoskeletons import WRONG_EXOSKELETONS
from tests.conformance.wrong_hearing import WRONG_HEARING
from tests.conformance.wrong_nodes import WRONG_NODES as WRONG_FRAMES
from tests.conformance.wrong_reports import WRONG_REPORTS
from tests.conformance.wrong_tacttips import WRONG_TACTTIPS
from tests.conformance.wrong_telemanipulators import WRONG_TELEMANIPULATORS

ALL = frozenset(How)
WRONG_MODULES = WRONG_REPORTS + WRONG_HEARING + WRONG_DRIVES + WRONG_CUT_OUTS + WRONG_TACTTIPS
WRONG_NODES = WRONG_FRAMES + WRONG_EXOSKELETONS + WRONG_TELEMANIPULATORS


def failures(results: list[Tried]) -> dict[str, str]:
    return {tried.duty.number: tried.came for tried in results if tried.verdict is Verdict.FAIL}


def named(value: object) -> str:
    return getattr(value, "__name__", str(value))


@pytest.mark.parametrize(("number", "make"), WRONG_MODULES, ids=named)
def test_a_wrong_module_fails_in_its_duty_alone(number: str, make: Callable[[], VirtualModule]) -> None:
    on_trial = module_on_trial(ModuleTalk(make(), told_finger=FINGER))
    assert failures(on_trial.tried(ALL, lambda _: None)).keys() == {number}


@pytest.mark.parametrize(("number", "name", "make"), WRONG_NODES, ids=named)
def test_a_wrong_node_fails_in_its_duty_alone(number: str, name: NodeName, make: Callable[[], VirtualNode]) -> None:
    on_trial = node_on_trial(NodeTalk(make(), KINDS[name]))
    assert failures(on_trial.tried(ALL, lambda _: None)).keys() == {number}


def test_every_duty_has_a_device_that_breaks_it() -> None:
    numbers = [duty.number for checklist in CHECKLISTS for duty in checklist.duties]
    assert len(set(numbers)) == len(numbers)
    broken = [number for number, _ in WRONG_MODULES] + [number for number, _, _ in WRONG_NODES]
    assert set(numbers) == set(broken)
