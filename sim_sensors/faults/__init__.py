"""Faults of simulated devices, and the port that commands them.

Tests and fault studies use the names in `faults`.
"""
