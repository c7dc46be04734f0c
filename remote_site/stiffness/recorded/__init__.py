"""Stiffness from recorded presses, off line.

The command line, the Python interface and maps use `identify_stiffness`.
"""
