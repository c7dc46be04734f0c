"""Calibration of thermal tables from labelled touches.

The command line uses `thermal_calibration` and `temperature_calibration`; reports use `expected_accuracy`.
"""
