"""Devices of the tests put on trial, each by the checklist of what it is."""

from teletaction.conformance.checklist import How, Tried, Verdict
from teletaction.conformance.examination import OnTrial, module_on_trial, node_on_trial
from teletaction.conformance.module_talk import ModuleTalk
from teletaction.conformance.node_talk import KINDS, NodeName, NodeTalk
from tests.unit.teletaction.conformance.virtual_ends import VirtualModule, VirtualNode

ALL = frozenset(How)


def on_trial(end: VirtualModule | VirtualNode, expected_finger: int | None = None) -> OnTrial:
    """A device that was found; for a module it may be said whose it should be."""
    if isinstance(end, VirtualModule):
        return module_on_trial(ModuleTalk(end, expected_finger=expected_finger))
    return node_on_trial(NodeTalk(end, KINDS[NodeName(type(end.node).__name__.lower())]))


def examined(
    end: VirtualModule | VirtualNode, allowed: frozenset[How] = ALL, expected_finger: int | None = None
) -> list[Tried]:
    """All its duties, tried as far as it is allowed."""
    return on_trial(end, expected_finger).tried(allowed, lambda _: None)


def came(results: list[Tried], *verdicts: Verdict) -> dict[str, str]:
    """What came of the duties that ended so, by their numbers."""
    return {tried.duty.number: tried.came for tried in results if tried.verdict in verdicts}
