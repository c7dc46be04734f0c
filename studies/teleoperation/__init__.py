"""Stability over a delayed link.

The registry runs `teleoperation_stability`.
"""
