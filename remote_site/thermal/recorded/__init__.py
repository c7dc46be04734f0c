"""Identification of recorded touches, off line.

The command line uses `identify_thermal`.
"""
