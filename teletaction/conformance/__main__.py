"""The duties as docs/protocols.md lists them: `python -m teletaction.conformance`."""

from teletaction.conformance.examination import CHECKLISTS

if __name__ == "__main__":
    print("\n\n".join(checklist.table() for checklist in CHECKLISTS))
