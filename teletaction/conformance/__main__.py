"""Print the duties as listed in docs/protocols.md: `python -m teletaction.conformance`."""

from teletaction.conformance.examination import CHECKLISTS

if __name__ == "__main__":
    print("\n\n".join(checklist.table() for checklist in CHECKLISTS))
