"""Recorded touches and strokes as CSV files.

Calibration and off-line identification use `trace_files`.
"""
