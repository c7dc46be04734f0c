"""Faults of simulated devices, and the port that commands them.

`faults` executes the commands, `kinds` lists the faults of each device.
"""
