"""Recorded touches, strokes and presses as CSV files.

Calibration, off-line identification and maps use `trace_files` and `press_files`.
"""
