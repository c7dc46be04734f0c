"""Vibration at the operator's finger.

`run` measures and `figure` draws.
"""
