"""Terminals, TCP ports and a CAN gateway that serve simulated devices.

`serving` and the processes use them.
"""
