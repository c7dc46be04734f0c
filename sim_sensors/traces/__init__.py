"""Simulated touches and strokes as labelled traces.

Calibration, tests and studies use `simulate`.
"""
