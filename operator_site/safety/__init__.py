"""Limits the outputs to motors, Peltier elements and finger forces: the gate and its parts.

The site uses `operator_gate`. This folder imports only `common`.
"""
