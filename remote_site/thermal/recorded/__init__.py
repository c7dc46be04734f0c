"""Off-line identification of recorded touches.

The command line uses `identify_thermal`.
"""
