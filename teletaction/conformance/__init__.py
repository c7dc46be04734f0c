"""Test one serial module or CAN node against docs/protocols.md, duty by duty, and always leave it neutral."""
