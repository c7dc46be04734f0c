"""Vibration at the operator's finger.

The registry runs `vibration`.
"""
