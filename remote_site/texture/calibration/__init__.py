"""Calibration of texture tables from labelled strokes.

The command line uses `texture_calibration` and `spectrum_calibration`.
"""
