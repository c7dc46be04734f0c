"""Measurement of the cost of a tick of each process, in lock step."""
