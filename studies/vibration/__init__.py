"""Vibration at the operator's finger."""
