"""Computes the vibration of a fingertip: taps, strokes and grooves.

Rendering uses `vibration` and `motor_drive`.
"""
